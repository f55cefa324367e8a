// Trajectories: arrays of (stamp_s, x_m, y_m, theta_rad).
#include "common/io/trajectory.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <filesystem>
#include <limits>
#include <vector>

#include "common/eval/metrics.h"
#include "common/inputs/open_truth.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

Array<double> read_trajectory(const std::filesystem::path& path, const ConfigBox* config) {
  const LogChoice choice = log_choice(config_or_default(config));
  Trajectory trajectory;
  {
    const nb::gil_scoped_release others_run;
    trajectory = open_truth(path.string(), choice);
  }
  return array_of(std::move(trajectory));
}

/// NaN where it is not known.
Array<double> poses_at(nb::handle trajectory, nb::handle stamps_s, double max_gap_s) {
  const auto known =
      truth_at(trajectory_from(trajectory, "trajectory"), doubles_from(stamps_s, "stamps_s"), max_gap_s);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<Pose> poses;
  for (const auto& pose : known) poses.push_back(pose.value_or(Pose{none, none, none}));
  return array_of<double>(std::move(poses), 3);
}

template <class Class>
void bind_errors_over_time(Class& type, const char* name, std::vector<double> TrackErrors::*member,
                           const char* doc) {
  type.def_prop_ro(
      name, [member](const TrackErrors& e) { return array_of<double>(std::vector<double>(e.*member), 1); },
      kOwnArray, doc);
}

}  // namespace

void bind_trajectory(nb::module_& m) {
  m.def("read_trajectory", &read_trajectory, "path"_a, "config"_a.none() = nb::none(),
        "Reads a trajectory, such as a truth: TUM text, a CARMEN log's FLASER lines, or a bag (config.log "
        "chooses the "
        "topic). Returns a float64 array of shape (N, 4), rows of (stamp_s, x_m, y_m, theta_rad). Raises "
        "InputError.");
  m.def(
      "write_trajectory",
      [](const std::filesystem::path& path, nb::handle trajectory) {
        const Trajectory rows = trajectory_from(trajectory, "trajectory");
        const nb::gil_scoped_release others_run;
        write_tum(path.string(), rows);
      },
      "path"_a, "trajectory"_a,
      nb::sig("def write_trajectory(path: str | os.PathLike, trajectory: numpy.typing.ArrayLike) -> None"),
      "Writes rows of (stamp_s, x_m, y_m, theta_rad) as TUM text, 6 decimals. Raises OutputError.");
  m.def("poses_at", &poses_at, "trajectory"_a, "stamps_s"_a, "max_gap_s"_a = 1.5,
        nb::sig("def poses_at(trajectory: numpy.typing.ArrayLike, stamps_s: numpy.typing.ArrayLike, "
                "max_gap_s: float = 1.5) -> NDArray[numpy.float64]"),
        "Poses of a trajectory at these times: the row of that stamp, else between the two around it if they "
        "are at most "
        "max_gap_s apart. Returns shape (N, 3), (x_m, y_m, theta_rad), NaN where there is none.");

  nb::class_<TrackErrors> errors(m, "TrackErrors", "Errors of a trajectory against the truth [m, rad].");
  errors.def_ro("compared", &TrackErrors::compared, "Poses that had a truth.")
      .def_ro("without_truth", &TrackErrors::without_truth, "Poses that had none.")
      .def_ro("position_rmse_m", &TrackErrors::position_rmse_m,
              "Root of the mean square of the distance [m].")
      .def_ro("position_mae_m", &TrackErrors::position_mae_m, "Mean distance [m].")
      .def_ro("position_max_m", &TrackErrors::position_max_m, "Largest distance [m].")
      .def_ro("position_p95_m", &TrackErrors::position_p95_m, "95 % of the distances are at or below it [m].")
      .def_ro("heading_rmse_rad", &TrackErrors::heading_rmse_rad,
              "Root of the mean square of the heading's error [rad].")
      .def_ro("heading_mae_rad", &TrackErrors::heading_mae_rad, "Mean of its size [rad].")
      .def_ro("heading_max_rad", &TrackErrors::heading_max_rad, "Its largest size [rad].")
      .def_ro("x_rmse_m", &TrackErrors::x_rmse_m, "Along the map's x axis [m].")
      .def_ro("y_rmse_m", &TrackErrors::y_rmse_m, "Along its y axis [m].");
  bind_errors_over_time(errors, "stamp_s", &TrackErrors::stamp_s, "Per pose compared: its stamp [s].");
  bind_errors_over_time(errors, "x_error_m", &TrackErrors::x_error_m, "Per pose compared, signed [m].");
  bind_errors_over_time(errors, "y_error_m", &TrackErrors::y_error_m, "Per pose compared, signed [m].");
  bind_errors_over_time(errors, "position_error_m", &TrackErrors::position_error_m, "Per pose compared [m].");
  bind_errors_over_time(errors, "heading_error_rad", &TrackErrors::heading_error_rad,
                        "Per pose compared [rad].");
  m.def(
      "compare_trajectories",
      [](nb::handle estimate, nb::handle truth, double max_gap_s) {
        return compare_tracks(trajectory_from(estimate, "estimate"), trajectory_from(truth, "truth"),
                              max_gap_s);
      },
      "estimate"_a, "truth"_a, "max_gap_s"_a = 1.5,
      nb::sig("def compare_trajectories(estimate: numpy.typing.ArrayLike, truth: numpy.typing.ArrayLike, "
              "max_gap_s: float = 1.5) -> TrackErrors"),
      "How far an estimate is from the truth, in the same frame; both are rows of (stamp_s, x_m, y_m, "
      "theta_rad).");
}

}  // namespace parloc::python
