"""The ament package parloc_ros: `colcon build` puts the node where `ros2 run parloc_ros amcl` finds it."""

from glob import glob

from setuptools import setup

name = "parloc_ros"

setup(
    name=name,
    version="0.1.0",
    packages=[name],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
        (f"share/{name}/launch", glob("launch/*.py")),
        (f"share/{name}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    description="parloc's localization in the place of nav2_amcl",
    license="see LICENSE of parloc",
    entry_points={"console_scripts": [f"amcl = {name}.amcl:main", f"slam = {name}.slam:main"]},
)
