// The backend of flow and Kalman filters over any memory space; what a space gives, says
// common/filter/engine/filter_engine.h.
#pragma once

#include <string>

#include "common/filter/engine/step_input_buffer.h"
#include "common/filter/engine/weighted_cloud.h"
#include "common/flow/flow_backend.h"
#include "common/flow/flow_stages.h"
#include "common/map/grid_map.h"

namespace parloc {

template <class Space>
class FlowEngine final : public FlowBackend {
 public:
  explicit FlowEngine(const FlowBackendConfig& config)
      : config_(config),
        queue_(Space::Queue::open(config.threads, config.device)),  // before anything is allocated
        room_(config.flow),
        cloud_(static_cast<std::size_t>(config.particles), config_.resample, weighs()) {
    queue_.reserve(cloud_.capacity());
    state_.reserve(1), weights_state_.reserve(1), move_.reserve(1);
  }

  std::string name() const override { return queue_.name(); }

  void set_map(const GridMap& map) override {
    queue_.use();
    Array<std::uint8_t> occupied;
    Array<std::uint32_t> squared;
    occupied.take(blocking_cells(map, false), queue_);
    squared.reserve(map.size());
    Space::squared_distance_field(occupied.data(), map.width, map.height, squared.data(), queue_);
    Array<DistancePair> table;  // beside the old one, which stays if there is no memory for this
    table.reserve(distance_table_size(map.width, map.height));
    Space::distance_table(squared.data(), map.width, map.height, table.data(), queue_);
    queue_.wait();         // before what it is made of goes
    recordings_.forget();  // they know the old table's place
    table_.swap(table);
    const FlowRules rules = bind_flow_rules(config_.flow, config_.method, map.resolution_m);
    args_ = FlowArgs{.field = {{table_.data(), map.width, map.height},
                               rules.interpolation,
                               rules.cap_cells,
                               map.resolution_m},
                     .rules = rules,
                     .state = state_.there(),
                     .move = move_.data()};
  }

  void start(const ParticleSet& particles, const PoseGaussian& gaussian) override {
    queue_.use();
    cloud_.upload(particles, queue_);
    *state_.host() = {};
    state_.host()->posterior = gaussian;
    *weights_state_.host() = {};
    state_.send(queue_), weights_state_.send(queue_);
    queue_.wait();
  }
  ParticleSet download() const override {
    queue_.use();
    return cloud_.download(cloud_.capacity(), queue_);
  }

  const FlowState& step(const MotionStep& motion, RandomKey key, const BeamTable* scan) override {
    static const BeamTable nothing;
    queue_.use();
    const BeamTable& beams = scan != nullptr ? *scan : nothing;
    if (!input_.has_room_for(beams)) recordings_.forget();  // they know the arrays' old place
    room_.set_scan(beams, input_);
    StepInput& input = input_.host();
    input.motion = motion;
    input.key = key;
    input.scan_worth = 0.0f;  // no running means of likelihoods
    args_.particles = cloud_.now();
    args_.input = input_.input();
    recordings_.run(cloud_.turn(), queue_, [this] { start_stages(); });
    queue_.wait();
    if (weighs()) cloud_.take_turns();
    return *state_.host();
  }
  const StepState& weights_state() const override { return *weights_state_.host(); }

 private:
  bool weighs() const { return config_.method == FlowMethod::pfpf; }

  void start_stages() {
    input_.send(queue_);
    if (is_kalman(config_.method)) {
      update_gaussian();
    } else if (weighs()) {
      weigh_particles();
    } else {
      Space::predict({cloud_.now(), input_.input()}, queue_);
      take_moments(args_.rules.prior == FlowPrior::sample);
      update_gaussian();
      if (moves_as_one(config_.method))
        Space::move_cloud(args_, queue_);
      else
        Space::flow_particles(args_, room_, queue_);
      take_moments(true);
    }
    Space::finish_update(args_, queue_);
    state_.fetch(queue_);
  }
  void update_gaussian() {
    Space::predict_mean(args_, queue_);
    if (args_.rules.z_score > 0.0) Space::reject_beams(args_, room_, queue_);
    Space::update_mean(args_, room_, queue_);
  }
  void take_moments(bool covariance) {
    Space::cloud_moments({.cloud = {cloud_.now()}, .covariance = covariance, .state = state_.there()},
                         queue_);
  }
  /// Particles propose for themselves; then as in any particle filter.
  void weigh_particles() {
    StepState* const weighed = weights_state_.there();
    update_gaussian();
    Space::flow_particles(args_, room_, queue_);
    cloud_.normalise(input_.input(), weighed, {}, false, queue_);
    Space::cloud_moments({.cloud = {cloud_.now(), cloud_.weights().weight},
                          .weighed = weighed,
                          .covariance = true,
                          .state = state_.there()},
                         queue_);
    cloud_.resample(input_.input(), weighed, {}, queue_);
    weights_state_.fetch(queue_);
  }

  template <class T>
  using Array = typename Space::template Array<T>;
  template <class T>
  using Mirror = typename Space::template Mirror<T>;

  FlowBackendConfig config_;
  typename Space::Queue queue_;
  typename Space::Recordings recordings_;
  typename Space::FlowRoom room_;
  StepInputBuffer<Space> input_;
  WeightedCloud<Space> cloud_;
  Array<DistancePair> table_;
  Array<CloudMove> move_;
  Mirror<FlowState> state_;
  Mirror<StepState> weights_state_;  // pfpf only
  FlowArgs args_;
};

}  // namespace parloc
