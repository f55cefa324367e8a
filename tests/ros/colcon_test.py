#!/usr/bin/env python3
"""`colcon build` of tools/ros in an ordinary workspace, as docs/ros.md says: what is installed, and that its programs start
with the file of parameters that comes along. PyPI has neither ros2 nor launch: the launch file is read with stubs in their
place, which keep what it says.
Usage: colcon_test.py PROGRAM, with ROS 2, colcon and parloc on PYTHONPATH; exit code 77 where they are missing."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import types
import unittest
from pathlib import Path
from unittest import mock

try:
    import robot
except ImportError as error:
    print(f"no ROS 2 here: {error}")
    sys.exit(77)
if importlib.util.find_spec("colcon_core") is None:
    print("no colcon here")
    sys.exit(77)

SOURCE = robot.ROOT / "tools" / "ros"


class Said:
    """In the place of an action or a substitution of launch: what it was made of."""

    def __init__(self, *words, **named):
        self.words, self.named = words, named


def stubs_of_launch():
    """The modules that a launch file imports, with Said in the place of every class."""
    names = ["launch", "launch.actions", "launch.substitutions", "launch_ros", "launch_ros.actions", "launch_ros.substitutions"]
    modules = {name: types.ModuleType(name) for name in names}
    for module in modules.values():
        module.__getattr__ = lambda name: type(name, (Said,), {})
    return modules


class Workspace(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.root = Path(cls.folder.name)
        (cls.root / "src").mkdir()
        (cls.root / "src" / "parloc_ros").symlink_to(SOURCE)
        paths = os.environ["PYTHONPATH"].split(":")
        cls.environment = {
            **os.environ,
            "PYTHONPATH": ":".join(path for path in paths if Path(path).resolve() != SOURCE),
            "COLCON_HOME": str(cls.root / "colcon"),
        }
        before = sorted(SOURCE.rglob("*"))
        words = [sys.executable, "-m", "colcon", "build", "--packages-select", "parloc_ros"]
        done = subprocess.run(words, cwd=cls.root, env=cls.environment, capture_output=True, text=True, timeout=120)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        if sorted(SOURCE.rglob("*")) != before:
            raise AssertionError("colcon has written into the sources")
        cls.prefix = cls.root / "install" / "parloc_ros"
        cls.share = cls.prefix / "share" / "parloc_ros"

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def in_workspace(self, command, **options):
        script = f"set -e; source {self.root}/install/setup.bash; {command}"
        return subprocess.Popen(["bash", "-c", script], env=self.environment, text=True, **options)

    def test_the_package_is_found_where_ros_looks(self):
        self.assertTrue((self.prefix / "share" / "ament_index" / "resource_index" / "packages" / "parloc_ros").is_file())
        for name in ("package.xml", "launch/amcl.launch.py", "config/nav2_params.yaml"):
            self.assertEqual((self.share / name).read_bytes(), (SOURCE / name).read_bytes())
        code = "import ament_index_python as a, parloc_ros as p; print(a.get_package_share_directory(p.__name__), p.__file__)"
        found = self.in_workspace(f'python3 -c "{code}"', stdout=subprocess.PIPE).communicate(timeout=30)[0]
        share, module = found.split()
        self.assertEqual(Path(share), self.share)
        self.assertTrue(Path(module).is_relative_to(self.prefix), module)

    def test_its_programs_start_and_can_be_configured(self):
        world = robot.World()
        for name in ("amcl", "slam"):
            with self.subTest(name), (self.root / name).with_suffix(".log").open("w+") as log:
                program = self.prefix / "lib" / "parloc_ros" / name
                words = f"exec {program} --ros-args --params-file {self.share}/config/nav2_params.yaml"
                node = self.in_workspace(words, stdout=log, stderr=subprocess.STDOUT)
                try:
                    self.assertEqual(world.wait_for_state(name), "unconfigured")
                    self.assertTrue(world.turn(robot.Transition.TRANSITION_CONFIGURE, name))
                    self.assertEqual(world.state(name), "inactive")
                finally:
                    node.terminate()
                    self.assertEqual(node.wait(20), 0, Path(log.name).read_text())
        world.close()

    def test_what_is_launched_is_there(self):
        spec = importlib.util.spec_from_file_location("amcl_launch", self.share / "launch" / "amcl.launch.py")
        module = importlib.util.module_from_spec(spec)
        with mock.patch.dict(sys.modules, stubs_of_launch()):
            spec.loader.exec_module(module)
            (actions,) = module.generate_launch_description().words
        nodes = {a.named["package"]: a.named for a in actions if "package" in a.named}
        self.assertEqual(sorted(nodes), ["nav2_lifecycle_manager", "parloc_ros"])
        amcl, manager = nodes["parloc_ros"], nodes["nav2_lifecycle_manager"]
        self.assertTrue(os.access(self.prefix / "lib" / "parloc_ros" / amcl["executable"], os.X_OK))
        self.assertEqual(manager["parameters"][0]["node_names"], [amcl["name"]])
        (file,) = [a.named["default_value"] for a in actions if a.words == ("params_file",) and a.named]
        package, *path = file.words[0]
        self.assertEqual(package.words, ("parloc_ros",))
        self.assertTrue(self.share.joinpath(*path).is_file())


if __name__ == "__main__":
    robot.begin()
    unittest.main(argv=sys.argv[:-1], verbosity=2)
