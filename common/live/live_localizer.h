// A localizer that is fed with a robot's messages, as they come.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/inputs/topic_role.h"
#include "common/localize/localizer.h"
#include "common/map/grid_map.h"

namespace parloc {

/// What is said to one scan.
struct LiveAnswer {
  double stamp_s = 0.0;        ///< The scan's.
  std::string lidar;           ///< Its topic without the slash.
  Pose odometry;               ///< T_odom_base at that time, as the robot said it.
  LocalizerEstimate estimate;  ///< What the localizer says.
  Pose T_map_odom;             ///< What takes the robot's own odometry to the map: pose * odometry^-1.
  std::string why_skipped;     ///< Why the scan changed nothing; empty if it did.
};

/// What was made beside, ready to be put in: a localizer, or another map for the one that answers.
struct PreparedLocalizer {
  Config config;                                       ///< What it was made with.
  std::shared_ptr<Localizer> localizer;                ///< A new one, or the one that answers.
  std::optional<Localizer::PreparedMap> map;           ///< Which it has not been given yet.
  std::shared_ptr<std::vector<std::string>> warnings;  ///< Where the localizer tells what it notices.
};

/// Where a robot is, as far as is known. Without a pose it may be anywhere.
struct LiveStart {
  std::optional<Pose> pose_in_map{};  ///< T_map_base, if it is known.
  Covariance covariance{};            ///< How well; map frame.
};

/// Messages go in, answers come out: the same as `parloc run` gives to a bag of the same messages. Memory is
/// bounded, and nothing that a message can hold throws: what cannot be used is left out and told by
/// troubles(). Not thread-safe, but prepare().
class LiveLocalizer {
 public:
  /// `config.log` says which frames are the odometry's and the robot's. Without `odometry_topic` the odometry
  /// is a transform. There is no map yet: scans are let pass.
  explicit LiveLocalizer(const Config& config, bool odometry_topic = false);
  ~LiveLocalizer();
  LiveLocalizer(LiveLocalizer&&) noexcept;
  LiveLocalizer& operator=(LiveLocalizer&&) noexcept;

  /// Everything that depends on map and settings, which takes a while for a large map; another thread may
  /// call it beside the other methods. Scans whose stamps make no sense are refused (scan.check_stamps),
  /// whatever the settings say. Throws as Localizer.
  PreparedLocalizer prepare(const Config& config, const GridMap& map) const;
  /// Quick: the next scan is answered on that map, with those settings. Frames and topics stay those of the
  /// constructor. Where the map alone is another one, all goes on as with Localizer::replace_map: the same
  /// map again changes no bit. With other settings a filter begins anew where the robot is by the last answer
  /// and the odometry since: with the covariance of that answer, at each of the places if several were
  /// possible, or anywhere if it was lost and `localize.recover` says to look. What was learnt of the LiDARs
  /// is learnt again.
  void put(PreparedLocalizer prepared);
  /// Where the robot is now: the next scan is taken there. Throws Error{input} for a pose that is not on the
  /// map; then nothing has changed. Without a map it is remembered.
  void start(const LiveStart& start);
  bool has_map() const;  ///< Whether one was put.
  bool started() const;  ///< Whether start() was called, and there is a map.

  /// A message in CDR, as ROS 2 sends it.
  void take(TopicRole role, const std::string& topic, std::string_view bytes);
  /// The answer to the next scan that can be given one; nothing: more has to be taken first.
  std::optional<LiveAnswer> next();
  /// The next scan of each LiDAR is weighed though the robot stands (update_min_d).
  void weigh_next();
  /// The robot's clock was set: what was taken is forgotten, the estimate stays where it is.
  void forget();

  /// Throws Error{usage} without a map.
  const Localizer& localizer() const;
  std::size_t waiting() const;  ///< Scans without an answer yet.
  /// Each once, as it is seen: "robot: /scan: expected at least one range, found 0".
  std::vector<std::string> troubles();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
