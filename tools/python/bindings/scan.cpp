// Scans of LiDARs, their ranges from and to numpy.
#include "common/model/scan.h"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <string>

#include "common/error.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

void make_scan(Scan* self, nb::handle ranges_m, double angle_min_rad, double angle_step_rad, double stamp_s,
               const std::string& sensor, const PoseLike& T_base_sensor, bool upside_down, double range_min_m,
               double range_max_m, double scan_time_s, nb::object bearings_rad, nb::object beam_times_s) {
  std::vector<float> ranges = floats_from(ranges_m, "ranges_m");
  std::vector<double> bearings, times;
  if (!bearings_rad.is_none()) bearings = doubles_from(bearings_rad, "bearings_rad");
  if (!beam_times_s.is_none()) times = doubles_from(beam_times_s, "beam_times_s");
  const auto check = [&](const std::vector<double>& own, const char* name) {
    if (!own.empty() && own.size() != ranges.size())
      throw Error(ErrorKind::input,
                  fmt::format("{}: expected one per range, {}, got {}", name, ranges.size(), own.size()));
  };
  check(bearings, "bearings_rad");
  check(times, "beam_times_s");
  new (self) Scan{
      stamp_s,     sensor,      T_base_sensor.pose, upside_down,       angle_min_rad,       angle_step_rad,
      range_min_m, range_max_m, scan_time_s,        std::move(ranges), std::move(bearings), std::move(times)};
}

/// A view of what the scan holds, which never grows.
template <class Scalar>
Array<Scalar> view(nb::handle_t<Scan> self, std::vector<Scalar> Scan::*member) {
  std::vector<Scalar>& values = nb::cast<Scan&>(self).*member;
  const std::size_t shape[] = {values.size()};
  return {values.data(), 1, shape, self};
}

}  // namespace

void bind_scan(nb::module_& m) {
  nb::class_<Scan>(
      m, "Scan",
      "One scan of a LiDAR, as it was recorded. Beam i looks at angle_min_rad + i * angle_step_rad in the "
      "LiDAR's frame, or at bearings_rad[i] if there are any.")
      .def("__init__", &make_scan, "ranges_m"_a, "angle_min_rad"_a = 0.0, "angle_step_rad"_a = 0.0,
           nb::kw_only(), "stamp_s"_a = 0.0, "sensor"_a = "", "T_base_sensor"_a = PoseLike{},
           "upside_down"_a = false, "range_min_m"_a = 0.0, "range_max_m"_a = 0.0, "scan_time_s"_a = 0.0,
           "bearings_rad"_a = nb::none(), "beam_times_s"_a = nb::none(),
           nb::sig("def __init__(self, ranges_m: numpy.typing.ArrayLike, angle_min_rad: float = 0.0, "
                   "angle_step_rad: float = 0.0, *, stamp_s: float = 0.0, sensor: str = '', "
                   "T_base_sensor: Pose | Sequence[float] = (0.0, 0.0, 0.0), upside_down: bool = False, "
                   "range_min_m: float = 0.0, range_max_m: float = 0.0, scan_time_s: float = 0.0, "
                   "bearings_rad: numpy.typing.ArrayLike | None = None, "
                   "beam_times_s: numpy.typing.ArrayLike | None = None) -> None"),
           "ranges_m: one dimension, float32 without conversion; may hold NaN, infinity, zeros. Everything "
           "is copied. "
           "Raises TypeError for what are no numbers, InputError where lengths differ.")
      .def_prop_ro(
          "ranges_m", [](nb::handle_t<Scan> self) { return view(self, &Scan::ranges_m); },
          "float32 array, one range per beam [m]: a view, no copy.")
      .def_prop_ro(
          "bearings_rad", [](nb::handle_t<Scan> self) { return view(self, &Scan::bearings_rad); },
          "float64 array, where each beam looks in the LiDAR's frame [rad]; empty: evenly. A view.")
      .def_prop_ro(
          "beam_times_s", [](nb::handle_t<Scan> self) { return view(self, &Scan::beam_times_s); },
          "float64 array, when each beam was taken, relative to the stamp [s]; empty: evenly. A view.")
      .def_rw("stamp_s", &Scan::stamp_s, "Time of the scan [s].")
      .def_rw("sensor", &Scan::sensor, "Which LiDAR; may be empty where there is one.")
      .def_rw("T_base_sensor", &Scan::T_base_sensor, "The LiDAR's pose on the robot.")
      .def_rw("upside_down", &Scan::upside_down, "Mirrored about its own x axis: angles run clockwise.")
      .def_rw("angle_min_rad", &Scan::angle_min_rad, "Where beam 0 looks [rad].")
      .def_rw("angle_step_rad", &Scan::angle_step_rad, "From beam to beam [rad].")
      .def_rw("range_min_m", &Scan::range_min_m, "Shortest range [m]; 0: not said.")
      .def_rw("range_max_m", &Scan::range_max_m, "Longest range [m]; 0: not said.")
      .def_rw("scan_time_s", &Scan::scan_time_s, "From the first beam to the last [s]; 0: not said.")
      .def("__len__", [](const Scan& scan) { return scan.ranges_m.size(); })
      .def("__repr__", [](const Scan& scan) {
        return fmt::format("<parloc.Scan {}{}{} beams at {:.6f} s>", scan.sensor,
                           scan.sensor.empty() ? "" : ": ", scan.ranges_m.size(), scan.stamp_s);
      });
}

}  // namespace parloc::python
