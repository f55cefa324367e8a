#include "common/live/answer_messages.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace parloc {
namespace {

DiagnosticMessage::Level level_of(HealthState state) {
  using Level = DiagnosticMessage::Level;
  return state == HealthState::tracking ? Level::ok : state == HealthState::lost ? Level::error : Level::warn;
}

std::string place_text(const Mode& mode) {
  return fmt::format("{:.2f} m, {:.2f} m, {:.2f} rad: {:.0f} %", mode.pose.x_m, mode.pose.y_m,
                     mode.pose.theta_rad, 100.0 * mode.weight);
}

}  // namespace

MessageWriter pose_message(const LiveAnswer& answer, const LiveFrames& frames) {
  const Estimate& estimate = answer.estimate.filter;
  return write_pose_with_covariance({answer.stamp_s, frames.map}, estimate.pose, estimate.covariance.v);
}

MessageWriter map_odom_message(const LiveAnswer& answer, const LiveFrames& frames, double tolerance_s) {
  return write_transforms(
      {{{answer.stamp_s + tolerance_s, frames.map}, frames.odom, spatial(answer.T_map_odom)}});
}

MessageWriter particles_message(const LiveAnswer& answer, const LiveFrames& frames,
                                const Localizer& localizer, std::size_t most) {
  std::vector<WeightedPose> particles;
  for (const Particle& p : localizer.filter().particles(most))
    particles.push_back({{p.x_m, p.y_m, p.theta_rad}, p.weight});
  return write_particles({answer.stamp_s, frames.map}, particles);
}

MessageWriter diagnostics_message(const LiveAnswer& answer, const LiveFrames& frames,
                                  const std::string& name) {
  const LocalizerEstimate& e = answer.estimate;
  DiagnosticMessage message;
  message.header = {answer.stamp_s, frames.map};
  message.level = level_of(e.health.state);
  message.name = name;
  message.message = name_of(e.health.state);
  message.values = {{"probability", fmt::format("{:.3f}", e.health.probability)},
                    {"evidence", fmt::format("{:.3f}", e.health.evidence)},
                    {"particles", fmt::format("{}", e.filter.particles)},
                    {"n_eff", fmt::format("{:.1f}", e.filter.n_eff)},
                    {"lidar", answer.lidar},
                    {"skipped", answer.why_skipped},
                    {"places", fmt::format("{}", e.modes.size())}};
  for (std::size_t k = 0; k < e.modes.size(); ++k)
    message.values.emplace_back(fmt::format("place {}", k + 1), place_text(e.modes[k]));
  return write_diagnostics(message);
}

}  // namespace parloc
