#include "tools/evaluate/decided_trials.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include "common/math/philox.h"

namespace parloc::tools::evaluate {
namespace {

/// Takes results as they come and gives them to the answer in their order.
class InOrder {
 public:
  /// `each` results, of as many configurations, are a trial.
  InOrder(const std::vector<std::size_t>& items, std::size_t each, Answer& answer)
      : items_(items), each_(each), answer_(answer) {}

  void take(std::size_t item, TrialResult result) {
    waiting_.emplace(item, std::move(result));
    while (!answer_.decided() && next_ < items_.size() && next_is_here()) {
      const auto first = waiting_.find(items_[next_] * each_);
      answer_.add(first->second, each_ == 2 ? &std::next(first)->second : nullptr);
      counted_.emplace(items_[next_++], std::move(first->second));
      waiting_.erase(first, std::next(first, static_cast<std::ptrdiff_t>(each_)));
    }
  }
  std::size_t left() const { return waiting_.size() / each_; }
  std::vector<TrialResult> counted() {
    std::vector<TrialResult> trials;
    for (auto& [item, result] : counted_) trials.push_back(std::move(result));
    return trials;
  }

 private:
  bool next_is_here() const {
    for (std::size_t k = 0; k < each_; ++k)
      if (waiting_.count(items_[next_] * each_ + k) == 0) return false;
    return true;
  }

  const std::vector<std::size_t>& items_;
  std::size_t each_;
  Answer& answer_;
  std::size_t next_ = 0;
  std::map<std::size_t, TrialResult> waiting_, counted_;
};

}  // namespace

DecidedTrials trials_until_decided(TrialsRequest request, const LogSource& source, const GridMap& map,
                                   Answer& answer) {
  InOrder in_order(request.items, request.other ? 2 : 1, answer);
  std::mutex mutex;
  std::atomic<bool> decided = false;
  request.stop = [&, stop = request.stop] { return decided || (stop && stop()); };
  const double trial_s = run_trials(request, source, map, [&](std::size_t item, double, TrialResult result) {
    const std::lock_guard lock(mutex);
    in_order.take(item, std::move(result));
    decided = answer.decided();
  });
  return {in_order.counted(), in_order.left(), trial_s};
}

std::vector<std::size_t> shuffled(std::size_t n) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t k = n; k > 1; --k) {
    const auto below = static_cast<std::uint32_t>(k);
    std::swap(order[k - 1], order[uniform_below(philox(below, 0, 0, 0, 0).w[0], below)]);
  }
  return order;
}

}  // namespace parloc::tools::evaluate
