// What filters have in common, bound to each of their classes.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/filter/particle_filter.h"
#include "common/localize/localizer.h"
#include "tools/python/values/arguments.h"
#include "tools/python/values/config_box.h"
#include "tools/python/values/guarded.h"
#include "tools/python/values/log_scans.h"

namespace parloc::python {

inline const PoseFilter& filter_in(const PoseFilter& filter) {
  return filter;
}
inline const PoseFilter& filter_in(const Localizer& localizer) {
  return localizer.filter();
}

/// Standard deviations in x, y [m] and heading [rad]; those of the configuration if none are given.
inline std::array<double, 3> sigmas_or_default(const std::optional<PoseLike>& given, const Config& config) {
  if (!given) return {config.initial_sigma_xy, config.initial_sigma_xy, config.initial_sigma_theta};
  return {given->pose.x_m, given->pose.y_m, given->pose.theta_rad};
}

/// A start about a pose, seeds, odometry and steps.
template <class Filter>
void bind_steps(nanobind::class_<Guarded<Filter>>& type) {
  namespace nb = nanobind;
  using namespace nb::literals;
  using Held = Guarded<Filter>;
  type.def(
          "start_at",
          [](Held& self, const PoseLike& pose, const std::optional<PoseLike>& sigma) {
            const auto s = sigmas_or_default(sigma, self.config());
            self.use([&](Filter& filter) { filter.start_at(pose.pose, s[0], s[1], s[2]); });
          },
          "pose"_a, "sigma"_a = nb::none(),
          "The start is known, about: a pose in the map frame, and standard deviations of x, y [m] and theta "
          "[rad], by "
          "default config.initial_sigma_xy and _theta. Raises InputError if it is not finite or not on the "
          "map.")
      .def(
          "set_seed",
          [](Held& self, std::uint64_t seed) { self.use([&](Filter& filter) { filter.set_seed(seed); }); },
          "seed"_a, "From the next start on.")
      .def(
          "add_odometry",
          [](Held& self, double stamp_s, const PoseLike& odometry) {
            self.use([&](Filter& filter) { filter.add_odometry(stamp_s, odometry.pose); });
          },
          "stamp_s"_a, "odometry"_a,
          "An odometry reading between steps, in any order; it matters only for scans that take time, and "
          "before the step.")
      .def(
          "step",
          [](Held& self, const PoseLike& odometry, const Scan& scan) {
            return self.use([&](Filter& filter) { return filter.step(odometry.pose, scan); });
          },
          "odometry"_a, "scan"_a,
          "Moves by the odometry since the last call (first call: not at all) and takes the scan in. "
          "`odometry` is the "
          "pose of the base in the odometry frame at the scan's stamp. Other threads run meanwhile.")
      .def(
          "step",
          [](Held& self, const ScanRecord& record) {
            return self.use([&](Filter& filter) { return record.step(filter); });
          },
          "record"_a, "The same with a record of a log, the odometry before it included.")
      .def_prop_ro(
          "config", [](const Held& self) { return new ConfigBox(self.config()); },
          nb::rv_policy::take_ownership, "A copy of the configuration that it was made of.");
}

/// Methods that are written in Python (tools/python/parloc).
template <class Filter>
void bind_runs(nanobind::class_<Guarded<Filter>>& type) {
  namespace nb = nanobind;
  using namespace nb::literals;
  type.def(
          "run",
          [](nb::handle self, nb::handle log, nb::handle start, nb::handle progress) {
            return nb::module_::import_("parloc.tracks").attr("run")(self, log, start, progress);
          },
          "log"_a, "start"_a = nb::none(), "progress"_a = false,
          nb::sig(
              "def run(self, log: parloc.tracks.LogLike, start: Pose | Sequence[float] | str | None = None, "
              "progress: parloc.progress.ProgressOption = False) -> parloc.tracks.Track"),
          "Takes in all scans of a log: the file's name, what open_log() gives, or any ScanRecords. `start` "
          "is a pose of "
          "the map frame, or 'global' for a localizer that is to find it; None: it was started, or goes on. "
          "`progress`: True for a bar by rich, or a function of the share read and the scans so far. Ctrl-C "
          "ends it "
          "between two scans; what there was until then is in the exception's `track`, and so it is if the "
          "log "
          "is damaged further on. Raises InputError for a log without a scan.")
      .def(
          "plot",
          [](nb::handle self, std::size_t most, nb::handle ax) {
            return nb::module_::import_("parloc.plotting").attr("plot_filter")(self, most, ax);
          },
          "most"_a = 2000, "ax"_a = nb::none(),
          nb::sig("def plot(self, most: int = 2000, ax: object = None) -> object"),
          "Draws the map and at most `most` particles; returns the axes. Needs matplotlib.");
}

/// What a filter says of itself.
template <class Filter>
void bind_readings(nanobind::class_<Guarded<Filter>>& type) {
  namespace nb = nanobind;
  using namespace nb::literals;
  using Held = Guarded<Filter>;
  type.def(
          "particles",
          [](Held& self, std::optional<std::size_t> most) {
            return array_of<float>(
                self.use([&](Filter& f) { return filter_in(f).particles(most.value_or(SIZE_MAX)); }), 4);
          },
          "most"_a = nb::none(),
          "float32 array of shape (N, 4), rows of (x_m, y_m, theta_rad, weight) in the map frame, after the "
          "last step; at "
          "most `most`, evenly by slot. Weights are shares of all.")
      .def(
          "digest", [](Held& self) { return self.use([](Filter& f) { return filter_in(f).digest(); }); },
          "SHA-256, as hex, of the particles and every step's estimate: the same on every machine, and that "
          "of the program.")
      .def(
          "beam_counts",
          [](Held& self) { return self.use([](Filter& f) { return filter_in(f).beam_counts(); }); },
          "What became of the beams of all LiDARs since the start.")
      .def(
          "lidars_used",
          [](Held& self) { return self.use([](Filter& f) { return filter_in(f).lidars_used(); }); },
          "The same by LiDAR, in the order in which they came.")
      .def_prop_ro(
          "steps", [](Held& self) { return self.use([](Filter& f) { return filter_in(f).steps(); }); },
          "Steps since the start.")
      .def_prop_ro(
          "why_skipped",
          [](Held& self) {
            return self.use([](Filter& f) { return std::string(filter_in(f).why_skipped()); });
          },
          "Why the last step's scan changed nothing; empty if it did.")
      .def_prop_ro(
          "odometry_jumps",
          [](Held& self) { return self.use([](Filter& f) { return filter_in(f).odometry_jumps(); }); },
          "Steps that no robot makes.")
      .def_prop_ro(
          "odometry_invalid",
          [](Held& self) { return self.use([](Filter& f) { return filter_in(f).odometry_invalid(); }); },
          "Steps that were skipped since their odometry was not finite.")
      .def_prop_ro(
          "backend_name",
          [](Held& self) { return self.use([](Filter& f) { return filter_in(f).backend_name(); }); },
          "'cpu (AVX-512, 2 threads)' or 'cuda (device name)'.")
      .def_prop_ro(
          "map", [](Held& self) { return self.use([](Filter& f) { return GridMap(filter_in(f).map()); }); },
          "A copy of the map.");
}

}  // namespace parloc::python
