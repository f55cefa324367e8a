// The particles of one filter in the memory of its backend, and the two stages that all filters with weights
// share.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/filter/filter_backend.h"

namespace parloc {

/// Two sets of poses that take turns, and what belongs to weights. `weighs` false: only one set is in use,
/// and nothing but its poses and log-weights.
template <class Space>
class WeightedCloud {
 public:
  using Queue = typename Space::Queue;

  /// `resample` outlives the cloud. To be done after Queue::use().
  WeightedCloud(std::size_t capacity, const ResampleConfig& resample, bool weighs = true)
      : capacity_(capacity), resample_(resample) {
    const std::size_t weighed = weighs ? capacity : 0;
    log_weight_.reserve(capacity);
    poses_[0].reserve(capacity);
    poses_[1].reserve(weighed);
    for (auto* b : {&weight_, &cumulative_}) b->reserve(weighed);
    if (Space::kSumsInBlocks) before_.reserve(sum_blocks(weighed));
    ancestor_.reserve(weighed);
    if (resample.scheme != ResampleScheme::residual) return;
    for (auto* b : {&offspring_sum_, &remainder_sum_}) b->reserve(weighed);
  }

  std::size_t capacity() const { return capacity_; }
  /// Which of the two sets is the current one.
  unsigned turn() const { return turn_; }
  void take_turns() { turn_ ^= 1; }

  Particles now() { return view(poses_[turn_]); }
  /// What resample() writes.
  Particles other() { return view(poses_[turn_ ^ 1]); }
  Weights weights() {
    return {weight_.data(), cumulative_.data(), Space::kSumsInBlocks ? before_.data() : nullptr};
  }
  const std::uint32_t* ancestor() { return ancestor_.data(); }

  void upload(const ParticleSet& p, Queue& queue) {
    turn_ = 0;
    poses_[0].x.from_host(p.x, queue);
    poses_[0].y.from_host(p.y, queue);
    poses_[0].theta.from_host(p.theta, queue);
    log_weight_.from_host(p.log_weight, queue);
    const std::vector<std::uint32_t> count = {static_cast<std::uint32_t>(p.x.size())};
    for (PoseArrays& poses : poses_) poses.live.from_host(count, queue);
    queue.wait();
  }
  /// The first `count`.
  ParticleSet download(std::size_t count, const Queue& queue) const {
    const PoseArrays& p = poses_[turn_];
    return {p.x.to_host(count, queue), p.y.to_host(count, queue), p.theta.to_host(count, queue),
            log_weight_.to_host(count, queue)};
  }
  std::vector<std::uint64_t> weights(std::size_t count, const Queue& queue) const {
    return weight_.to_host(count, queue);
  }
  std::vector<std::uint64_t> cumulative(std::size_t count, const Queue& queue) const {
    std::vector<std::uint64_t> sums = cumulative_.to_host(count, queue);
    if (!Space::kSumsInBlocks) return sums;
    const std::vector<std::uint64_t> before = before_.to_host(sum_blocks(count), queue);
    for (std::size_t i = 0; i < count; ++i) sums[i] += before[i / kSumBlock];
    return sums;
  }
  std::vector<std::uint32_t> ancestors(std::size_t count, const Queue& queue) const {
    return ancestor_.to_host(count, queue);
  }

  /// `just_weighed`: NormaliseArgs.
  void normalise(const StepInput* input, StepState* state, const RecoveryRates& recovery, bool just_weighed,
                 Queue& queue) {
    Space::normalise_scan({.particles = now(),
                           .weights = weights(),
                           .threshold = resample_.threshold,
                           .always = resample_.threshold >= 1.0,
                           .state = state,
                           .recovery = recovery,
                           .input = input,
                           .just_weighed = just_weighed},
                          queue);
  }
  /// take_turns() afterwards.
  void resample(const StepInput* input, const StepState* state, const FreeSpace& free, Queue& queue) {
    Space::resample({.from = now(),
                     .to = other(),
                     .weights = weights(),
                     .scheme = resample_.scheme,
                     .input = input,
                     .state = state,
                     .ancestor = ancestor_.data(),
                     .offspring_sum = offspring_sum_.data(),
                     .remainder_sum = remainder_sum_.data(),
                     .free = free},
                    queue);
  }

 private:
  template <class T>
  using Array = typename Space::template Array<T>;
  struct PoseArrays {
    Array<float> x, y, theta;
    Array<std::uint32_t> live;
    void reserve(std::size_t capacity) {
      for (auto* b : {&x, &y, &theta}) b->reserve(capacity);
      live.reserve(1);
    }
  };
  /// Log-weights stay in their slots, so that one array serves both sets.
  Particles view(PoseArrays& p) {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), p.live.data(), capacity_};
  }

  std::size_t capacity_;
  const ResampleConfig& resample_;
  PoseArrays poses_[2];
  unsigned turn_ = 0;
  Array<float> log_weight_;
  Array<std::uint64_t> weight_, cumulative_, before_;
  Array<std::uint32_t> ancestor_;
  Array<std::uint64_t> offspring_sum_, remainder_sum_;  // residual scheme only
};

}  // namespace parloc
