// A map from a log.
#include "common/slam/grid_slam.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <filesystem>

#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"
#include "tools/python/values/guarded.h"
#include "tools/python/values/log_scans.h"
#include "tools/slam/log_oddities.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

using HeldSlam = Guarded<GridSlam>;

void make_slam(HeldSlam* self, const ConfigBox* config) {
  Config given = config_or_default(config);
  const nb::gil_scoped_release others_run;
  new (self) HeldSlam(std::move(given), [](const Config& c) { return GridSlam(grid_slam_config(c)); });
}

std::unique_ptr<HeldSlam> load(const std::filesystem::path& path) {
  const nb::gil_scoped_release others_run;
  SlamCheckpoint checkpoint(path.string());
  return std::make_unique<HeldSlam>(config_of(checkpoint.config),
                                    [&](const Config&) { return GridSlam(std::move(checkpoint)); });
}

/// Loops first, so that Ctrl-C can end that, then what is asked for.
template <class Use>
auto closed(HeldSlam& self, Use use) {
  return self.use([&](GridSlam& slam) {
    slam.close_loops([](double) {
      const nb::gil_scoped_acquire ours;
      heed_signals();
    });
    return use(slam);
  });
}

void bind_steps_of(nb::class_<HeldSlam>& type) {
  type.def(
          "add_odometry",
          [](HeldSlam& self, double stamp_s, const PoseLike& odometry) {
            self.use([&](GridSlam& slam) { slam.add_odometry(stamp_s, odometry.pose); });
          },
          "stamp_s"_a, "odometry"_a,
          "An odometry reading between steps; matters only for scans that take time.")
      .def(
          "step",
          [](HeldSlam& self, const PoseLike& odometry, const Scan& scan) {
            return self.use([&](GridSlam& slam) { return slam.step(odometry.pose, scan); });
          },
          "odometry"_a, "scan"_a,
          "Takes a scan in if the robot has moved far enough since the last one that counted; whether it "
          "did. `odometry` "
          "is the pose of the base in the odometry frame. Other threads run meanwhile.")
      .def(
          "step",
          [](HeldSlam& self, const ScanRecord& record) {
            return self.use([&](GridSlam& slam) { return record.step(slam); });
          },
          "record"_a, "The same with a record of a log.");
}

/// Methods that are written in Python (tools/python/parloc).
void bind_runs_of(nb::class_<HeldSlam>& type) {
  type.def(
          "run",
          [](nb::handle self, nb::handle log, nb::handle progress) {
            return nb::module_::import_("parloc.tracks").attr("run_slam")(self, log, progress);
          },
          "log"_a, "progress"_a = false,
          nb::sig("def run(self, log: parloc.tracks.LogLike, progress: parloc.progress.ProgressOption = "
                  "False) -> int"),
          "Takes in all scans of a log, as Localizer.run() does; returns how many there were. make_map() "
          "chooses the "
          "odometry, too.")
      .def(
          "plot",
          [](nb::handle self, nb::handle ax) {
            return nb::module_::import_("parloc.plotting").attr("plot_slam")(self, ax);
          },
          "ax"_a = nb::none(), nb::sig("def plot(self, ax: object = None) -> object"),
          "Draws the map and the trajectory, loops closed; returns the axes. Needs matplotlib.");
}

void bind_results(nb::class_<HeldSlam>& type) {
  type.def(
          "map", [](HeldSlam& self) { return closed(self, [](GridSlam& slam) { return slam.map(); }); },
          "The map of the most likely particle, its origin where the first scan was taken. With "
          "slam.close_loops the "
          "loops are closed first, which takes a while.")
      .def(
          "trajectory",
          [](HeldSlam& self) {
            return array_of(closed(self, [](GridSlam& slam) { return slam.trajectory(); }));
          },
          "float64 array of shape (N, 4): rows of (stamp_s, x_m, y_m, theta_rad) in the map frame, one per "
          "scan, likewise.")
      .def(
          "digest", [](HeldSlam& self) { return closed(self, [](GridSlam& slam) { return slam.digest(); }); },
          "SHA-256, as hex, of trajectory() and the cells of map(): that of the program.")
      .def(
          "close_loops", [](HeldSlam& self) { closed(self, [](GridSlam&) {}); },
          "Closes the loops now, if they are to be closed. Ctrl-C ends it as if it had not been asked for.")
      .def(
          "map_so_far",
          [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.map_so_far(); }); },
          "The map as the particle has it, whatever slam.close_loops says: for pictures on the way.")
      .def(
          "trajectory_so_far",
          [](HeldSlam& self) {
            return array_of(self.use([](GridSlam& slam) { return slam.trajectory_so_far(); }));
          },
          "The same of the trajectory.")
      .def(
          "digest_so_far",
          [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.digest_so_far(); }); },
          "The same of the digest.")
      .def(
          "poses",
          [](HeldSlam& self) {
            return array_of<double>(self.use([](GridSlam& slam) { return slam.poses(); }), 3);
          },
          "float64 array of shape (N, 3): where the particles were at the last scan that counted, (x_m, y_m, "
          "theta_rad).")
      .def(
          "odometry",
          [](HeldSlam& self) { return array_of(self.use([](GridSlam& slam) { return slam.odometry(); })); },
          "float64 array of shape (N, 4): the odometry at every scan, as recorded or from the scans.");
}

void bind_state(nb::class_<HeldSlam>& type) {
  type.def(
          "save",
          [](HeldSlam& self, const std::filesystem::path& path) {
            self.use([&](GridSlam& slam) { slam.save(path.string()); });
          },
          "path"_a, "Writes everything that is needed to go on from here with load(). Raises OutputError.")
      .def_static("load", &load, "path"_a,
                  "Goes on from what save() wrote, to the same bits as without the break. Raises InputError.")
      .def(
          "records", [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.records(); }); },
          "One SlamRecord per scan that was taken in.")
      .def(
          "loops", [](HeldSlam& self) { return closed(self, [](GridSlam& slam) { return slam.loops(); }); },
          "What became of the loops; None without slam.close_loops.")
      .def(
          "distinct_ancestors",
          [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.distinct_ancestors(); }); },
          "By scan that counted: how many different poses the particles of now have behind them there.")
      .def_prop_ro(
          "best", [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.best(); }); },
          "Slot of the most likely particle.")
      .def_prop_ro(
          "memory_bytes",
          [](HeldSlam& self) {
            const SlamMemory memory = self.use([](GridSlam& slam) { return slam.memory(); });
            return memory.tile_bytes + memory.table_bytes + memory.sub_map_bytes;
          },
          "What the maps of all particles take together now.")
      .def_prop_ro(
          "odometry_jumps",
          [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.odometry_jumps(); }); },
          "Steps that no robot makes.")
      .def_prop_ro(
          "backend_name",
          [](HeldSlam& self) { return self.use([](GridSlam& slam) { return slam.backend_name(); }); },
          "'cpu (AVX-512, 2 threads)' or 'cuda (device name)'.")
      .def_prop_ro(
          "config", [](const HeldSlam& self) { return new ConfigBox(self.config()); },
          nb::rv_policy::take_ownership, "A copy of the configuration that it was made of.");
}

}  // namespace

void bind_slam(nb::module_& m) {
  nb::class_<SlamRecord>(m, "SlamRecord", "One scan that was taken in.")
      .def_ro("stamp_s", &SlamRecord::stamp_s, "Its time [s].")
      .def_ro("n_eff", &SlamRecord::n_eff, "Effective number of particles.")
      .def_ro("resampled", &SlamRecord::resampled, "The particles were drawn anew.")
      .def_ro("tiles", &SlamRecord::tiles, "In use by all particles together.")
      .def_ro("handed_over", &SlamRecord::handed_over, "Tiles of far places, one for all particles.");
  nb::class_<LoopCounts>(m, "LoopCounts", "Pieces of the path that were compared with earlier ones.")
      .def_ro("tried", &LoopCounts::tried, "Pairs of pieces that may lie in one place.")
      .def_ro("found", &LoopCounts::found, "Of them fitted well, and in one place only.")
      .def_ro("used", &LoopCounts::used, "Of these agreed with others and were held to.")
      .def_ro("most_moved_m", &LoopCounts::most_moved_m, "Greatest correction of a pose of the path [m].");
  nb::class_<HeldSlam> type(
      m, "GridSlam",
      "Mapping without a map: a particle filter whose particles each carry a grid map. Settings are "
      "those of config.slam. Deterministic; one call at a time.");
  type.def("__init__", &make_slam, "config"_a.none() = nb::none(), "Raises ConfigError and BackendError.");
  bind_steps_of(type);
  bind_runs_of(type);
  bind_results(type);
  bind_state(type);
  m.def(
      "odometry_stands_still",
      [](const Log& log) {
        const nb::gil_scoped_release others_run;
        return tools::slam::odometry_stands_still(*log.open(log.config));
      },
      "log"_a,
      "Whether a log of two scans or more has the same odometry throughout: then config.slam.odometry = "
      "'scans' makes "
      "its map, which `parloc slam` chooses by itself.");
}

}  // namespace parloc::python
