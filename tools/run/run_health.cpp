#include "tools/run/run_health.h"

#include <fmt/format.h>

#include <algorithm>

namespace parloc::tools {
namespace {

std::string modes_text(const std::vector<Mode>& modes) {
  constexpr std::size_t most = 4;
  std::string text;
  for (std::size_t i = 0; i < modes.size() && i < most; ++i) {
    const Pose& p = modes[i].pose;
    text += fmt::format("{}({:.2f} m, {:.2f} m, {:.2f} rad) with {:.0f} %", i == 0 ? "" : ", ", p.x_m, p.y_m,
                        p.theta_rad, 100.0 * modes[i].weight);
  }
  if (modes.size() > most) text += fmt::format(" and {} more", modes.size() - most);
  return text;
}

}  // namespace

std::optional<RunHealth> run_health(const Localization& run) {
  if (run.steps.empty() || !run.steps.front().health) return std::nullopt;
  RunHealth h;
  HealthState before = run.steps.front().health->state;
  for (const StepRecord& step : run.steps) {
    const HealthState state = step.health->state;
    ++h.scans;
    ++(state == HealthState::tracking ? h.tracking : state == HealthState::ambiguous ? h.ambiguous : h.lost);
    h.searches += step.searched ? 1 : 0;
    if (state == HealthState::lost && before != HealthState::lost) h.lost_s.push_back(step.stamp_s);
    before = state;
  }
  h.last = *run.steps.back().health;
  h.modes = run.modes;
  return h;
}

std::string health_text(const RunHealth& h) {
  const auto percent = [&](std::size_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(h.scans);
  };
  return fmt::format("tracking {:.1f} %, ambiguous {:.1f} %, lost {:.1f} % of the scans; searched {} time{}",
                     percent(h.tracking), percent(h.ambiguous), percent(h.lost), h.searches,
                     h.searches == 1 ? "" : "s");
}

std::string doubt_at_end(const Localization& run) {
  const std::optional<RunHealth> h = run_health(run);
  if (!h || h->last.state == HealthState::tracking) return "";
  const std::string probability = fmt::format("with probability {:.2f}", h->last.probability);
  if (h->last.state == HealthState::lost)
    return fmt::format("LOST at the end: the scans do not fit the map there; right {}", probability);
  if (h->modes.size() > 1)
    return fmt::format("AMBIGUOUS at the end: {} places are possible: {}", h->modes.size(),
                       modes_text(h->modes));
  return fmt::format("AMBIGUOUS at the end: other places may explain the scans as well; right {}",
                     probability);
}

}  // namespace parloc::tools
