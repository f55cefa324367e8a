#include "tools/evaluate/run_trials.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace parloc::evaluate {
namespace {

LocalizerConfig one_thread(LocalizerConfig config) {
  config.filter.threads = 1;
  config.search.threads = 1;
  return config;
}

class Pool {
 public:
  Pool(const TrialsRequest& request, const TrialSource& source, const GridMap& map)
      : request_(request),
        config_(one_thread(request.config)),
        source_(source),
        map_(map),
        results_(request.trials),
        fractions_(static_cast<std::size_t>(request.jobs)) {}

  std::vector<TrialResult> run() {
    std::vector<std::thread> threads;
    running_ = request_.jobs;
    for (std::size_t worker = 0; worker < fractions_.size(); ++worker)
      threads.emplace_back([this, worker] { work_guarded(worker); });
    watch();
    for (std::thread& thread : threads) thread.join();
    if (error_) std::rethrow_exception(error_);
    std::vector<TrialResult> finished;
    for (std::optional<TrialResult>& result : results_)
      if (result) finished.push_back(std::move(*result));
    return finished;
  }

 private:
  void work_guarded(std::size_t worker) {
    try {
      work(worker);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      stopped_ = true;
    }
    --running_;
  }

  void work(std::size_t worker) {
    Localizer localizer(config_, map_);
    const auto keep_going = [&](double fraction) {
      fractions_[worker] = fraction;
      return !stopped_;
    };
    for (std::size_t k = next_++; k < request_.trials && !stopped_; k = next_++) {
      const std::uint64_t seed = request_.first_seed + k;
      results_[k] = run_trial(localizer, request_.plan, source_.trial(seed), seed, keep_going);
      fractions_[worker] = 0.0;
      if (results_[k]) ++finished_;
    }
  }

  /// On the caller's thread, until the last worker is done.
  void watch() {
    while (running_ > 0) {
      if (request_.stop && request_.stop()) stopped_ = true;
      if (request_.progress) {
        double done = static_cast<double>(finished_);
        for (const std::atomic<double>& fraction : fractions_) done += fraction;
        request_.progress(done / static_cast<double>(request_.trials), finished_);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  const TrialsRequest& request_;
  const LocalizerConfig config_;
  const TrialSource& source_;
  const GridMap& map_;
  std::vector<std::optional<TrialResult>> results_;  // each written by the one thread that has its trial
  std::vector<std::atomic<double>> fractions_;       // of the trial that each thread is in
  std::atomic<std::size_t> next_ = 0, finished_ = 0;
  std::atomic<int> running_ = 0;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace

std::vector<TrialResult> run_trials(const TrialsRequest& request, const TrialSource& source,
                                    const GridMap& map) {
  return Pool(request, source, map).run();
}

}  // namespace parloc::evaluate
