#include "tools/compare/run_all.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace parloc::compare {
namespace {

class Pool {
 public:
  Pool(const Request& request, const DriveSource& source, const GridMap& map)
      : request_(request), source_(source), map_(map), runs_(request.entries.size()) {
    outcome_.backends.resize(request.entries.size());
    for (auto& of_entry : runs_) of_entry.resize(request.seeds);
  }

  Outcome run() {
    std::vector<std::thread> threads;
    running_ = request_.jobs;
    for (int k = 0; k < request_.jobs; ++k) threads.emplace_back([this] { work_guarded(); });
    watch();
    for (std::thread& thread : threads) thread.join();
    if (error_) std::rethrow_exception(error_);
    for (auto& of_entry : runs_) {
      std::vector<FilterRun>& finished = outcome_.runs.emplace_back();
      for (auto& one : of_entry)
        if (one) finished.push_back(std::move(*one));
    }
    outcome_.finished = finished_;
    return std::move(outcome_);
  }

 private:
  void work_guarded() {
    try {
      work();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      stopped_ = true;
    }
    --running_;
  }

  /// Seed by seed, so that a log is made once for all filters.
  void work() {
    std::vector<std::unique_ptr<PoseFilter>> filters(request_.entries.size());
    for (std::size_t s = next_++; s < request_.seeds && !stopped_; s = next_++) {
      const std::uint64_t seed = request_.first_seed + s;
      const TrialLog log = source_.drive(seed);
      count(log);
      for (std::size_t k = 0; k < filters.size() && !stopped_; ++k) {
        if (!filters[k]) filters[k] = made(k);
        runs_[k][s] = follow(*filters[k], log, request_.start, seed, [&] { return !stopped_; });
        if (runs_[k][s]) ++finished_;
      }
    }
  }

  std::unique_ptr<PoseFilter> made(std::size_t k) {
    const Entry& e = request_.entries[k];
    auto filter = make_pose_filter(e.kind, e.config, map_);
    const std::lock_guard lock(mutex_);
    outcome_.backends[k] = filter->backend_name();
    return filter;
  }
  void count(const TrialLog& log) {
    const std::lock_guard lock(mutex_);
    outcome_.hits += log.hits;
    outcome_.unmapped += log.unmapped;
  }

  /// On the caller's thread, until the last worker is done.
  void watch() {
    const auto all = static_cast<double>(request_.seeds * request_.entries.size());
    while (running_ > 0) {
      if (request_.stop && request_.stop()) stopped_ = true;
      if (request_.progress) request_.progress(static_cast<double>(finished_) / all, finished_);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  const Request& request_;
  const DriveSource& source_;
  const GridMap& map_;
  std::vector<std::vector<std::optional<FilterRun>>>
      runs_;  // each written by the one thread that has its seed
  Outcome outcome_;
  std::atomic<std::size_t> next_ = 0, finished_ = 0;
  std::atomic<int> running_ = 0;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace

Outcome run_all(const Request& request, const DriveSource& source, const GridMap& map) {
  return Pool(request, source, map).run();
}

}  // namespace parloc::compare
