// The backend of the particle filter over any memory space. A space (cpu/space.h, cuda/space.h) gives arrays,
// a queue, the recording of repeated work and the stages; what is done with them, and in which order, is
// here.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/filter/beam_votes.h"
#include "common/filter/bind.h"
#include "common/filter/bins.h"
#include "common/filter/engine/map_tables.h"
#include "common/filter/engine/step_input_buffer.h"
#include "common/filter/engine/weighted_cloud.h"

namespace parloc {

/// A table of bins in the memory of a backend. Empty, for so many particles.
template <class Space>
class BinArrays {
 public:
  BinArrays(std::size_t particles, typename Space::Queue& queue) : capacity_(bin_capacity(particles)) {
    for (auto* b : {&key_, &weight_}) b->reserve(capacity_);
    parent_.reserve(capacity_);
    for (auto* b : {&slot_of_, &used_}) b->reserve(particles);
    used_count_.reserve(1);
    Space::clear_bins(view(), queue);
  }
  BinTable view() {
    return {.key = key_.data(),
            .weight = weight_.data(),
            .parent = parent_.data(),
            .slot_of = slot_of_.data(),
            .used = used_.data(),
            .used_count = used_count_.data(),
            .capacity = capacity_};
  }

 private:
  std::uint32_t capacity_;
  typename Space::template Array<std::uint64_t> key_, weight_, used_count_;
  typename Space::template Array<std::uint32_t> parent_, slot_of_, used_;
};

/// Stages are only noted when they are asked for; finish() starts them all, recorded as one piece where the
/// space can do that and the same step has been seen before.
template <class Space>
class FilterEngine final : public FilterBackend {
 public:
  explicit FilterEngine(const FilterBackendConfig& config)
      : config_(config),
        queue_(Space::Queue::open(config.threads, config.device, config.group)),  // before all that allocates
        cloud_(static_cast<std::size_t>(config.particles), config_.resample),
        bins_(cloud_.capacity(), queue_) {
    queue_.reserve(cloud_.capacity());
    state_.reserve(1);
    votes_.from_host(std::vector<std::uint64_t>(2 * kMaxBeams), queue_);
    share_.reserve(kMaxBeams);
    start_with(cloud_.capacity());
  }

  std::string name() const override { return queue_.name(); }

  void set_map(const GridMap& map) override {
    run_planned();
    MapTables<Space> tables;  // beside the old ones, which stay if there is no memory for these
    tables.set_map(map, config_.sensor, config_.injects(), config_.threads, queue_);
    recordings_.forget();  // they know the old map's place
    tables_ = std::move(tables);
  }
  void set_range_max(double range_max_m) override {
    if (casts()) return;
    run_planned();
    if (tables_.set_range_max(range_max_m, config_.sensor, queue_)) recordings_.forget();
  }

  void upload(const ParticleSet& particles) override {
    check_upload(particles, config_);
    run_planned();
    cloud_.upload(particles, queue_);
    start_with(particles.x.size());
  }
  ParticleSet download() const override {
    expect_finished();
    return cloud_.download(now_count_, queue_);
  }

  void predict(const MotionStep& motion, RandomKey key) override {
    plan(kPredict);
    use_key(key);
    input_.host().motion = motion;
    input_.host().scan_worth = 0.0f;
  }

  void set_scan(const BeamTable& t) override {
    queue_.use();
    if (planned_ >= kWeight) run_planned();
    StepInput& input = input_.host();
    input.models = bind_ray_models(config_.sensor, t.range_max_m);
    input.tempering = bind_tempering(config_.sensor, t);
    input.scan_worth = bind_scan_worth(config_.sensor, t);
    if (!input_.has_room_for(t)) recordings_.forget();  // they know the arrays' old place
    input_.set_scan(t);
    if (Space::kGivesUpEarly && casts()) scatter_beams(t, scattered_);
  }

  std::vector<float> ray_trace() override {
    run_planned();
    reserve_expected();
    input_.send(queue_);
    trace();
    return expected_m_.to_host(now_count_ * input_.host().scan.count, queue_);
  }

  void weight(bool fused) override {
    const bool stored = !fused && casts();
    if (stored) reserve_expected();  // before it is planned: there may be no memory for it
    plan(stored ? kWeightUnfused : kWeight);
  }
  void normalise_scan() override { plan(kNormalise); }
  void estimate() override { plan(kEstimate); }
  void adapt(RandomKey key, bool all) override {
    if (!config_.adapts()) return;
    plan(kAdapt);
    use_key(key);
    input_.host().all_particles = all ? 1 : 0;
  }
  void resample(RandomKey key) override {
    plan(kResample);
    use_key(key);
  }

  StepState finish() override {
    run_planned();
    return *state_.host();
  }
  std::vector<std::uint64_t> weights() const override {
    expect_finished();
    return cloud_.weights(weighed_count_, queue_);
  }
  std::vector<std::uint64_t> cumulative() const override {
    expect_finished();
    return cloud_.cumulative(weighed_count_, queue_);
  }
  std::vector<std::uint32_t> ancestors() const override {
    expect_finished();
    return cloud_.ancestors(now_count_, queue_);
  }

 private:
  /// What has been asked for and not yet been started, as a sum; the stages run in this order.
  enum Stage : unsigned {
    kPredict = 1,
    kWeight = 2,
    kWeightUnfused = 4,
    kNormalise = 8,
    kEstimate = 16,
    kAdapt = 32,
    kResample = 64,
  };

  bool casts() const { return casts_rays(config_.sensor.model); }

  void plan(Stage stage) {
    if (planned_ >= stage) run_planned();  // not in a step's order
    planned_ |= stage;
  }
  void use_key(RandomKey key) {
    RandomKey& used = input_.host().key;
    const unsigned asking = std::bit_floor(planned_);
    if (planned_ != asking && (used.seed != key.seed || used.step != key.step)) {
      planned_ -= asking;
      run_planned();
      planned_ = asking;
    }
    used = key;
  }

  void run_planned() {
    queue_.use();
    const unsigned planned = std::exchange(planned_, 0u);  // whatever comes of it, it is not tried again
    if (planned == 0) return;
    recordings_.finish(planned + 2 * kResample * cloud_.turn(), queue_, [=, this] { start_stages(planned); });
    weighed_count_ = state_.host()->count;
    if ((planned & kResample) != 0) {
      cloud_.take_turns();
      now_count_ = state_.host()->next_count;
    }
  }

  /// So many particles are in the arrays; there has been no step.
  void start_with(std::size_t count) {
    now_count_ = weighed_count_ = count;
    StepState& state = *state_.host() = {};
    state.count = state.next_count = static_cast<std::uint32_t>(count);
    state_.send(queue_);
    queue_.wait();
  }

  /// Everything that differs from the last such step is in input_, so this may be recorded.
  void start_stages(unsigned planned) {
    const auto asked = [planned](unsigned stages) { return (planned & stages) != 0; };
    StepState* const state = state_.there();
    input_.send(queue_);
    if (asked(kPredict)) Space::predict({cloud_.now(), input_.input()}, queue_);
    if (asked(kWeightUnfused)) trace();
    if (asked(kWeight | kWeightUnfused)) weigh(asked(kWeightUnfused));
    const bool weighed = asked(kWeight | kWeightUnfused);
    if (asked(kNormalise))
      cloud_.normalise(input_.input(), state, bind_recovery(config_.recovery), weighed, queue_);
    if (asked(kEstimate)) Space::estimate({cloud_.now(), cloud_.weights(), bins_.view(), state}, queue_);
    if (asked(kAdapt)) choose_number();
    if (asked(kResample)) cloud_.resample(input_.input(), state, tables_.free_space(), queue_);
    state_.fetch(queue_);
  }

  void trace() {
    RayTraceArgs args = ray_args(input_.beams());
    args.expected_m = expected_m_.data();
    Space::ray_trace(args, queue_);
  }
  void weigh(bool stored) {
    const bool scattered = Space::kGivesUpEarly && casts() && !stored;
    WeightArgs args{.rays = ray_args(scattered ? bind_beams(scattered_) : input_.beams()),
                    .model = config_.sensor.model,
                    .field = tables_.field(config_.sensor),
                    .skip = tables_.beam_skip(config_.sensor),
                    .votes = {votes_.data(), votes_.data() + kMaxBeams, share_.data()},
                    .state = state_.there()};
    if (stored) args.rays.expected_m = expected_m_.data();
    if (needs_beam_votes(args)) Space::beam_votes(args, queue_);
    Space::weight(args, queue_);
  }
  void choose_number() {
    Space::adapt({.from = cloud_.now(),
                  .to = cloud_.other(),
                  .weights = cloud_.weights(),
                  .rule = bind_kld(config_.kld, config_.min_particles, config_.particles),
                  .free = tables_.free_space(),
                  .bins = bins_.view(),
                  .state = state_.there(),
                  .input = input_.input()},
                 queue_);
  }

  void expect_finished() const {
    if (planned_ != 0)
      throw Error(ErrorKind::internal, "FilterBackend: expected finish() before reading results");
    queue_.use();
  }
  void reserve_expected() {
    queue_.use();
    const std::size_t size = cloud_.capacity() * input_.host().scan.count;
    if (size > expected_m_.size()) recordings_.forget();  // they know the old place
    expected_m_.reserve(size);
  }
  RayTraceArgs ray_args(const Beams& beams) {
    RayTraceArgs args = bind_rays(cloud_.now(), tables_.ray_map(), beams, config_.sensor);
    args.input = input_.input();
    return args;
  }

  template <class T>
  using Array = typename Space::template Array<T>;

  FilterBackendConfig config_;
  typename Space::Queue queue_;
  typename Space::Recordings recordings_;
  MapTables<Space> tables_;
  StepInputBuffer<Space> input_;
  BeamTable scattered_;         // only where particles are given up early
  Array<std::uint64_t> votes_;  // zero between the steps
  Array<float> share_;
  Array<float> expected_m_;  // unfused reference only
  WeightedCloud<Space> cloud_;
  BinArrays<Space> bins_;
  typename Space::template Mirror<StepState> state_;
  std::size_t now_count_ = 0, weighed_count_ = 0;  // as the stages have them, after finish()
  unsigned planned_ = 0;                           // sum of Stage
};

}  // namespace parloc
