"""parloc on a robot with ROS 2: a lifecycle node in the place of nav2_amcl."""
