#include "tools/bench/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>
#include <vector>

#include "common/error.h"
#include "tools/bench/steps/memory.h"

namespace parloc::tools::bench {
namespace {

constexpr const char* kNoTime = "no time was left for it (--quick)";

}  // namespace

bool Recorder::go_on() {
  if (control_.stopped()) results_.interrupted = true;
  return !results_.interrupted;
}

void Recorder::tell(const std::string& what) {
  control_.tell(static_cast<double>(done_++) / static_cast<double>(std::max<std::size_t>(total_, 1)), what);
}

std::string Recorder::name(const Row& row) const {
  return fmt::format("{}, {}", name_of(row.place, row.particles, row.beams),
                     name_of(results_.variants[row.variant]));
}

std::unique_ptr<Rig> Recorder::make_rig(const Scene& scene, Cloud cloud, std::size_t variant,
                                        std::int64_t particles, std::string& why) {
  why.clear();
  if (control_.out_of_time()) why = kNoTime;
  if (why.empty()) why = too_large(results_.variants[variant], particles, available_bytes());
  if (!why.empty()) return nullptr;
  try {
    auto rig = std::make_unique<Rig>(results_.variants[variant], scene, cloud, particles);
    results_.backends[variant] = rig->backend_name();
    return rig;
  } catch (const std::bad_alloc&) {
    why = "there is not enough memory";
  } catch (const Error& e) {  // of a device, for example its memory
    why = e.what();
  }
  return nullptr;
}

std::optional<TimeSummary> Recorder::time_steps(Rig& rig, const Row& row) {
  try {
    rig.use_beams(row.beams);
    const auto time = measure([&] { return rig.step_seconds(); }, results_.rules, control_);
    if (!time) results_.interrupted = true;
    return time;
  } catch (const std::bad_alloc&) {
    results_.skipped.push_back({name(row), "there is not enough memory"});
  } catch (const Error& e) {
    results_.skipped.push_back({name(row), e.what()});
    results_.failed = true;
  }
  return std::nullopt;
}

/// Medians of each stage, over a few steps: about as long again as the row itself took.
void Recorder::add_stages(Rig& rig, Row& row) {
  const auto wanted = static_cast<int>(0.5 * results_.rules.seconds / row.time.median_s);
  const int steps = std::clamp(wanted, 1, 200);
  std::array<std::vector<double>, kStageNames.size()> seconds;
  for (int k = 0; k < steps && (k == 0 || !control_.out_of_time()); ++k) {
    if (!go_on()) return;
    const StageSeconds one = rig.stage_seconds();
    for (std::size_t s = 0; s < one.size(); ++s) seconds[s].push_back(one[s]);
  }
  StageSeconds medians{};
  for (std::size_t s = 0; s < medians.size(); ++s)
    medians[s] = summarise_times(std::move(seconds[s])).median_s;
  row.stages = medians;
}

void Recorder::measure_row(Rig* rig, Row row, const std::string& why) {
  if (!go_on()) return;
  tell(fmt::format("{} {}x{}", row.place.scene, row.particles, row.beams));
  if (rig == nullptr || control_.out_of_time()) {
    results_.skipped.push_back({name(row), rig == nullptr ? why : kNoTime});
    return;
  }
  const std::optional<TimeSummary> time = time_steps(*rig, row);
  if (!time) return;
  row.time = *time;
  if (row.sweep != Sweep::tables && row.sweep != Sweep::peers && !control_.out_of_time())
    add_stages(*rig, row);
  results_.rows.push_back(std::move(row));
}

std::optional<TimeSummary> Recorder::measure_alone(Rig& rig, const Row& row) {
  if (!go_on()) return std::nullopt;
  return time_steps(rig, row);
}

}  // namespace parloc::tools::bench
