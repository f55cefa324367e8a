// What filters say after a step.
#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "common/filter/pose/pose_guess.h"
#include "common/filter/pose_filter.h"
#include "common/localize/localizer.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

constexpr const char* kCovariance =
    "float64 array of shape (3, 3) of (x, y, theta) [m^2, m rad, rad^2], map frame; a copy.";

void bind_filter_estimate(nb::module_& m) {
  nb::class_<PoseEstimate>(m, "PoseEstimate", "A weighted mean and its covariance, in the map frame.")
      .def_ro("mean", &PoseEstimate::mean, "Its heading is the circular mean.")
      .def_prop_ro(
          "covariance", [](const PoseEstimate& e) { return array_of(e.covariance); }, kOwnArray, kCovariance)
      .def_ro("weight", &PoseEstimate::weight, "Share of the total weight, 0 to 1.")
      .def_ro("heading_resultant", &PoseEstimate::heading_resultant,
              "Of the circular mean: 1 is certain, 0 undefined.");
  nb::class_<Estimate>(m, "Estimate", "What one step of a filter says.")
      .def_ro("pose", &Estimate::pose, "In the map frame: of the mode that config.estimate.mode chooses.")
      .def_prop_ro(
          "covariance", [](const Estimate& e) { return array_of(e.covariance); }, kOwnArray, kCovariance)
      .def_ro("mean", &Estimate::mean, "Of all particles.")
      .def_ro("cluster", &Estimate::cluster,
              "Of the heaviest connected cluster of 0.5 m x 0.5 m x 10 degree bins.")
      .def_ro("n_eff", &Estimate::n_eff, "Effective number of particles.")
      .def_ro("particles", &Estimate::particles, "That were weighed.")
      .def_ro("p_injected", &Estimate::p_injected,
              "Share of the next particles that is drawn from free space.")
      .def_ro("beam_likelihood", &Estimate::beam_likelihood,
              "Of the last scan used: geometric mean over its beams; 0: none yet.")
      .def_ro("weighted", &Estimate::weighted, "A scan was used, else only the motion.")
      .def_ro("resampled", &Estimate::resampled, "The particles were drawn anew.")
      .def_ro("lost", &Estimate::lost, "Every particle had weight zero.")
      .def_ro("ambiguous_heading", &Estimate::ambiguous_heading,
              "The mean's heading is undefined; the cluster's was taken.")
      .def("__repr__", [](const Estimate& e) {
        return fmt::format("<parloc.Estimate x {:.3f} m, y {:.3f} m, theta {:.4f} rad>", e.pose.x_m,
                           e.pose.y_m, e.pose.theta_rad);
      });
}

void bind_localizer_estimate(nb::module_& m) {
  nb::class_<Mode>(m, "Mode", "A place where the robot may be.")
      .def_ro("pose", &Mode::pose, "In the map frame.")
      .def_ro("weight", &Mode::weight, "Share of the total, 0 to 1.");
  nb::class_<LocalizerEstimate>(m, "LocalizerEstimate", "What a localizer says after a scan.")
      .def_prop_ro(
          "pose", [](const LocalizerEstimate& e) { return e.filter.pose; }, "In the map frame.")
      .def_prop_ro(
          "covariance", [](const LocalizerEstimate& e) { return array_of(e.filter.covariance); }, kOwnArray,
          kCovariance)
      .def_prop_ro(
          "state", [](const LocalizerEstimate& e) { return std::string(name_of(e.health.state)); },
          "'tracking', 'ambiguous' (look at modes) or 'lost' (do not use the pose).")
      .def_prop_ro(
          "probability", [](const LocalizerEstimate& e) { return e.health.probability; },
          "That the pose is within 0.5 m and 10 degrees of the truth.")
      .def_prop_ro(
          "evidence", [](const LocalizerEstimate& e) { return e.health.evidence; },
          "What the scans say for the pose, smoothed [nat per beam].")
      .def_prop_ro(
          "log_odds", [](const LocalizerEstimate& e) { return e.health.log_odds; },
          "What they say together, before it is calibrated [nat].")
      .def_ro("modes", &LocalizerEstimate::modes,
              "While ambiguous: the places that are possible, most likely first.")
      .def_ro("searched", &LocalizerEstimate::searched, "The whole map was searched at this scan.")
      .def_ro("found", &LocalizerEstimate::found, "Hypotheses of that search.")
      .def_ro("filter", &LocalizerEstimate::filter, "What the particle filter says.")
      .def("__repr__", [](const LocalizerEstimate& e) {
        const Pose& p = e.filter.pose;
        return fmt::format(
            "<parloc.LocalizerEstimate {}: x {:.3f} m, y {:.3f} m, theta {:.4f} rad, probability {:.2f}>",
            name_of(e.health.state), p.x_m, p.y_m, p.theta_rad, e.health.probability);
      });
}

void bind_beams(nb::module_& m) {
  nb::class_<BeamCounts>(m, "BeamCounts", "What became of beams.")
      .def_ro("total", &BeamCounts::total, "In the scans.")
      .def_ro("considered", &BeamCounts::considered, "After decimation to scan.max_beams.")
      .def_ro("used", &BeamCounts::used, "Gave evidence.")
      .def_ro("misses", &BeamCounts::misses, "Among the considered: nothing within range.")
      .def_ro("masked", &BeamCounts::masked, "Among the considered: they see the robot itself.")
      .def_prop_ro("rejected", &BeamCounts::rejected, "NaN, -infinity, negative, zero or below the minimum.");
  nb::class_<LidarUse>(m, "LidarUse", "What became of one LiDAR's scans.")
      .def_ro("name", &LidarUse::name, "As the log calls it.")
      .def_ro("scans", &LidarUse::scans, "Whose beams were looked at.")
      .def_ro("too_few", &LidarUse::too_few,
              "Of these, with fewer usable beams than scan.min_beams: not weighed.")
      .def_ro("smallest", &LidarUse::smallest, "Fewest beams of a scan.")
      .def_ro("largest", &LidarUse::largest, "Most beams of a scan.")
      .def_ro("moving", &LidarUse::moving, "Scans that took time: every beam from where it was taken.")
      .def_ro("unknown_motion", &LidarUse::unknown_motion, "Took time, but no odometry tells the motion.")
      .def_ro("beams", &LidarUse::beams, "Of all of them.");
}

/// What the filter said, alone or with what a localizer says of it.
const Estimate& filter_estimate(nb::handle estimate) {
  LocalizerEstimate* judged = nullptr;
  if (nb::try_cast(estimate, judged, false) && judged != nullptr) return judged->filter;
  return nb::cast<const Estimate&>(estimate);
}

/// For whole runs, whose estimates are many.
void bind_columns(nb::module_& m) {
  m.def("poses_of", [](const nb::list& estimates) {
    std::vector<Pose> poses;
    poses.reserve(estimates.size());
    for (const nb::handle estimate : estimates) poses.push_back(filter_estimate(estimate).pose);
    return array_of<double>(std::move(poses), 3);
  });
  m.def("covariances_of", [](const nb::list& estimates) {
    std::vector<Covariance> covariances;
    covariances.reserve(estimates.size());
    for (const nb::handle estimate : estimates) covariances.push_back(filter_estimate(estimate).covariance);
    return array_of<double>(std::move(covariances), 9);
  });
}

}  // namespace

void bind_estimate(nb::module_& m) {
  nb::class_<PoseGuess>(m, "PoseGuess",
                        "A place where the robot may be, with its spread and how much speaks for it.")
      .def(
          "__init__",
          [](PoseGuess* self, const PoseLike& pose, double sigma_xy_m, double sigma_theta_rad,
             double weight) {
            new (self) PoseGuess{pose.pose, sigma_xy_m, sigma_theta_rad, weight};
          },
          "pose"_a, "sigma_xy_m"_a = 0.2, "sigma_theta_rad"_a = 0.1, "weight"_a = 1.0,
          "`weight` is relative to those of the other guesses.")
      .def_rw("pose", &PoseGuess::pose, "In the map frame.")
      .def_rw("sigma_xy_m", &PoseGuess::sigma_xy_m, "Standard deviation of its place [m].")
      .def_rw("sigma_theta_rad", &PoseGuess::sigma_theta_rad, "... and of its heading [rad].")
      .def_rw("weight", &PoseGuess::weight, "Relative to the others; above 0.");
  bind_filter_estimate(m);
  bind_localizer_estimate(m);
  bind_beams(m);
  bind_columns(m);
}

}  // namespace parloc::python
