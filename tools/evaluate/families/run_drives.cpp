#include "tools/evaluate/families/run_drives.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "common/eval/run_trial.h"
#include "common/filter/filter_group.h"
#include "common/localize/localizer.h"
#include "tools/program/run_items.h"
#include "tools/report/machine/statistics.h"

namespace parloc::tools::families {
namespace {

/// The two that drive on a map.
struct Pair {
  std::shared_ptr<const GridMap> map;
  Localizer closed, bare;
};

LocalizerConfig without_recovery(LocalizerConfig config) {
  config.localize.recover = false;
  return config;
}

/// One thread's localizers, of the maps that it had last: what a localizer makes of a map takes longer than a
/// drive.
class Localizers {
 public:
  explicit Localizers(const LocalizerConfig& config) : config_(config) {}

  Pair& on(const std::shared_ptr<const GridMap>& map) {
    auto found =
        std::find_if(pairs_.begin(), pairs_.end(), [&](const auto& pair) { return pair->map == map; });
    if (found == pairs_.end()) {
      if (pairs_.size() == kMost) pairs_.pop_back();
      pairs_.push_back(std::make_unique<Pair>(
          Pair{map, Localizer(config_, *map), Localizer(without_recovery(config_), *map)}));
      found = pairs_.end() - 1;
    }
    std::rotate(pairs_.begin(), found, found + 1);  // the last one used is the first
    return *pairs_.front();
  }

 private:
  static constexpr std::size_t kMost = 8;
  LocalizerConfig config_;
  std::vector<std::unique_ptr<Pair>> pairs_;
};

/// Fills in what the two runs say; false if the drive was stopped.
bool drive_twice(PreparedDrive& drive, Localizers& localizers, const std::function<bool(double)>& told) {
  Pair& pair = localizers.on(drive.trial.map);
  DriveResult& r = drive.result;
  const auto run = [&](Localizer& localizer, double from) {
    return run_trial(localizer, drive.trial.plan, drive.trial.log, r.seed,
                     [&](double fraction) { return told(from + 0.5 * fraction); });
  };
  std::optional<TrialResult> closed = run(pair.closed, 0.0);
  if (!closed) return false;
  std::optional<TrialResult> bare = run(pair.bare, 0.5);
  if (!bare) return false;
  r.closed = std::move(*closed);
  r.bare = std::move(*bare);
  r.events = static_cast<std::size_t>(std::count_if(
      drive.trial.events.begin(), drive.trial.events.end(),
      [](const CorruptionEvent& e) { return e.kind != CorruptionEvent::Kind::hidden_rotation; }));
  r.driven_s = r.closed.samples.back().stamp_s - r.closed.samples.front().stamp_s;
  r.closed_score = score_run(r.closed);
  r.bare_score = score_run(r.bare);
  r.comparison = compare_runs(r.closed_score, r.bare_score);
  return true;
}

}  // namespace

void run_drives(const DrivesRequest& request, const DriveSource& source, const KeepDrive& keep) {
  LocalizerConfig config = request.config;
  config.threads = 1;
  if (request.jobs > 1) config.group = make_filter_group(config);
  std::vector<std::atomic<double>> fractions(
      static_cast<std::size_t>(request.jobs));  // of each thread's drive
  std::atomic<std::size_t> finished = 0;
  const auto tell = [&] {
    if (!request.progress) return;
    double done = static_cast<double>(finished);
    for (const std::atomic<double>& fraction : fractions) done += fraction;
    request.progress(done / static_cast<double>(request.items.size()), finished);
  };
  const auto make_worker = [&](std::size_t thread, const KeepGoing& keep_going) -> Worker {
    const auto localizers = std::make_shared<Localizers>(config);
    return [&, thread, localizers](std::size_t k) {
      const Clock::time_point begun = Clock::now();
      PreparedDrive drive = source.prepare(request.items[k]);
      const auto told = [&](double fraction) {
        fractions[thread] = fraction;
        return keep_going();
      };
      const bool whole = drive_twice(drive, *localizers, told);
      fractions[thread] = 0.0;
      if (!whole) return;
      if (!request.samples) drive.result.closed.samples = drive.result.bare.samples = {};
      keep(request.items[k], seconds_since(begun), std::move(drive.result));
      ++finished;
    };
  };
  run_items({request.items.size(), request.jobs, request.stop, tell}, make_worker);
}

std::vector<DriveResult> run_drives(const DrivesRequest& request, const DriveSource& source) {
  std::map<std::size_t, DriveResult> results;
  std::mutex mutex;
  run_drives(request, source, [&](std::size_t item, double, DriveResult result) {
    const std::lock_guard lock(mutex);
    results.emplace(item, std::move(result));
  });
  std::vector<DriveResult> all;
  for (auto& [item, result] : results) all.push_back(std::move(result));
  return all;
}

}  // namespace parloc::tools::families
