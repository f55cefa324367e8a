// The bare filters, which track from a known start.
#include <nanobind/stl/array.h>

#include "common/config/pose_filters.h"
#include "common/error.h"
#include "common/filter/particle_filter.h"
#include "common/flow/flow_filter.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/bindings/filter_methods.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

using HeldParticleFilter = Guarded<ParticleFilter>;

/// A filter on the distance field, by its name.
class NamedFlow {
 public:
  NamedFlow(const std::string& method, const Config& config, const GridMap& map)
      : filter_(make_pose_filter(method, config, map)), method_(method) {}

  void start_at(const Pose& pose, double sigma_x_m, double sigma_y_m, double sigma_theta_rad) {
    filter_->start_at(pose, sigma_x_m, sigma_y_m, sigma_theta_rad);
  }
  void set_seed(std::uint64_t seed) { filter_->set_seed(seed); }
  void add_odometry(double stamp_s, const Pose& odometry) { filter_->add_odometry(stamp_s, odometry); }
  Estimate step(const Pose& odometry, const Scan& scan) { return filter_->step(odometry, scan); }
  const PoseFilter& filter() const { return *filter_; }
  const std::string& method() const { return method_; }

 private:
  std::unique_ptr<PoseFilter> filter_;
  std::string method_;
};
const PoseFilter& filter_in(const NamedFlow& flow) {
  return flow.filter();
}

void make_particle_filter(HeldParticleFilter* self, const GridMap& map, const ConfigBox* config) {
  Config given = config_or_default(config);
  const nb::gil_scoped_release others_run;
  new (self) HeldParticleFilter(std::move(given), [&](const Config& c) { return ParticleFilter(c, map); });
}

void make_flow_filter(Guarded<NamedFlow>* self, const std::string& method, const GridMap& map,
                      const ConfigBox* config) {
  if (method == "mcl" || method == "amcl")
    throw Error(ErrorKind::config,
                "filter '" + method + "': expected a flow or Kalman filter, this is a ParticleFilter");
  Config given = config_or_default(config);
  const nb::gil_scoped_release others_run;
  new (self) Guarded<NamedFlow>(std::move(given), [&](const Config& c) { return NamedFlow(method, c, map); });
}

void bind_particle_filter(nb::module_& m) {
  nb::class_<HeldParticleFilter> type(
      m, "ParticleFilter",
      "The particle filter alone: predict, weigh, resample. It needs a start, and does not know when it is "
      "lost: Localizer "
      "does. Deterministic; safe to use from several threads, one call at a time.");
  type.def("__init__", &make_particle_filter, "map"_a, "config"_a.none() = nb::none(),
           "Raises ConfigError for an impossible configuration, BackendError, InputError for a map without "
           "free cells.");
  bind_steps(type);
  bind_readings(type);
  bind_runs(type);
  type.def(
          "start_at",
          [](HeldParticleFilter& self, const std::vector<PoseGuess>& guesses) {
            self.use([&](ParticleFilter& f) { f.start_at(guesses); });
          },
          "guesses"_a, "About several guesses, each with its share of the particles.")
      .def(
          "start_anywhere",
          [](HeldParticleFilter& self) { self.use([](ParticleFilter& f) { f.start_anywhere(); }); },
          "Uniform over the free cells.")
      .def(
          "relocate",
          [](HeldParticleFilter& self, const std::vector<PoseGuess>& guesses, const PoseLike& odometry) {
            self.use([&](ParticleFilter& f) { f.relocate(guesses, odometry.pose); });
          },
          "guesses"_a, "odometry"_a,
          "Puts the particles there in the middle of a run, which goes on: the next step does not move them "
          "if its "
          "odometry is this one.")
      .def(
          "end_points",
          [](HeldParticleFilter& self, const Scan& scan) {
            return array_of<float>(self.use([&](ParticleFilter& f) { return f.end_points(scan); }), 2);
          },
          "scan"_a,
          "float32 array of shape (N, 2): where the beams that hit something ended, in the base frame [m].");
}

void bind_flow_filter(nb::module_& m) {
  nb::class_<Guarded<NamedFlow>> type(m, "FlowFilter",
                                      "Filters on the distance field, from a known start: Kalman filters "
                                      "('ekf', 'ekf_beams') and particle flows ('edh', "
                                      "'naedh', 'ledh', 'gromov', 'pfpf'). Settings are those of "
                                      "config.flow. Deterministic; one call at a time.");
  type.def("__init__", &make_flow_filter, "method"_a, "map"_a, "config"_a.none() = nb::none(),
           "Raises as ParticleFilter, and ConfigError for a method that is none.");
  bind_steps(type);
  bind_readings(type);
  bind_runs(type);
  type.def_prop_ro(
      "method", [](Guarded<NamedFlow>& self) { return self.use([](NamedFlow& f) { return f.method(); }); },
      "As given.");
}

}  // namespace

void bind_filters(nb::module_& m) {
  bind_particle_filter(m);
  bind_flow_filter(m);
}

}  // namespace parloc::python
