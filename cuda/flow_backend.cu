#include "common/flow/flow_backend.h"

#include "common/filter/bind.h"
#include "common/map/blocking_cells.h"
#include "cuda/device.h"
#include "cuda/distance_field.h"
#include "cuda/flow_stages.h"
#include "cuda/poses.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

/// A step is one graph from its second time on: what differs from step to step is in input_.
class CudaFlowBackend final : public FlowBackend {
 public:
  CudaFlowBackend(const FlowBackendConfig& config, std::string device_name)
      : config_(config),
        device_(selected(config.device)),  // before anything is allocated
        device_name_(std::move(device_name)),
        capacity_(static_cast<std::size_t>(config.particles)),
        a_(capacity_),
        b_(weighs() ? capacity_ : 0) {
    stream_ = make_stream();
    scratch_.reserve(capacity_);
    log_weight_.reserve(capacity_);
    state_.reserve(1), move_.reserve(1), weights_state_.reserve(1);
    state_up_.reserve(1), weights_state_up_.reserve(1);
    room_.mean.reserve(1), room_.beams.reserve(1);
    if (config.flow.z_score > 0.0) {
      distance_.reserve(kMaxBeams);
      keep_.reserve(kMaxBeams);
      kept_.reserve(1);
    }
    if (!weighs()) return;
    for (auto* b : {&weight_, &cumulative_}) b->reserve(capacity_);
    ancestor_.reserve(capacity_);
    if (config.resample.scheme == ResampleScheme::residual) {
      offspring_sum_.reserve(capacity_);
      remainder_sum_.reserve(capacity_);
    }
  }
  ~CudaFlowBackend() override {
    for (auto& step : steps_) step = {};
    free_stream(stream_);
  }

  std::string name() const override { return "cuda (" + device_name_ + ")"; }

  void set_map(const GridMap& map) override {
    select_device(device_);
    for (auto& step : steps_) step = {};  // they know the old map's place
    const std::vector<std::uint8_t> occupied = blocking_cells(map, false);
    DeviceBuffer<std::uint8_t> is_source;
    DeviceBuffer<std::uint32_t> squared;
    is_source.from_host(occupied, stream_);
    squared.reserve(map.size());
    squared_distance_field(is_source.data(), map.width, map.height, squared.data(), stream_);
    table_.reserve(distance_table_size(map.width, map.height));
    distance_table(squared.data(), map.width, map.height, table_.data(), stream_);
    synchronise(stream_);
    rules_ = bind_flow_rules(config_.flow, config_.method, map.resolution_m);
    field_ = {
        {table_.data(), map.width, map.height}, rules_.interpolation, rules_.cap_cells, map.resolution_m};
  }

  void start(const ParticleSet& p, const PoseGaussian& gaussian) override {
    select_device(device_);
    now_ = &a_, other_ = &b_;
    a_.x.from_host(p.x, stream_);
    a_.y.from_host(p.y, stream_);
    a_.theta.from_host(p.theta, stream_);
    log_weight_.from_host(p.log_weight, stream_);
    const std::vector<std::uint32_t> count = {static_cast<std::uint32_t>(p.x.size())};
    for (Poses* poses : {&a_, &b_}) poses->live.from_host(count, stream_);
    FlowState state;
    state.posterior = gaussian;
    const std::vector<FlowState> states = {state};
    state_.from_host(states, stream_);
    const std::vector<StepState> weights_states(1);
    weights_state_.from_host(weights_states, stream_);
    synchronise(stream_);
  }
  ParticleSet download() const override {
    select_device(device_);
    return {now_->x.to_host(capacity_, stream_), now_->y.to_host(capacity_, stream_),
            now_->theta.to_host(capacity_, stream_), log_weight_.to_host(capacity_, stream_)};
  }

  const FlowState& step(const MotionStep& motion, RandomKey key, const BeamTable* scan) override {
    static const BeamTable nothing;
    select_device(device_);
    input_.host().motion = motion;
    input_.host().key = key;
    input_.host().scan_worth = 0.0f;  // no running means of likelihoods
    if (input_.set_scan(scan != nullptr ? *scan : nothing))
      for (auto& step : steps_) step = {};  // they know the arrays' old place
    steps_[now_ == &a_ ? 0 : 1].run(stream_, [this] { start_stages(); });
    synchronise(stream_);
    if (weighs()) std::swap(now_, other_);
    return *state_up_.data();
  }
  const StepState& weights_state() const override { return *weights_state_up_.data(); }

 private:
  bool weighs() const { return config_.method == FlowMethod::pfpf; }
  Particles view(const Poses& p) const {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), p.live.data(), capacity_};
  }

  void start_stages() {
    input_.copy_to_device(stream_);
    const Particles cloud = view(*now_);
    if (is_kalman(config_.method)) {
      update_gaussian();
    } else if (weighs()) {
      start_weighted_stages(cloud);
    } else {
      predict(cloud, input_.device(), stream_);
      cloud_moments({cloud, nullptr}, nullptr, rules_.prior == FlowPrior::sample, state_.data(), scratch_,
                    stream_);
      update_gaussian();
      if (moves_as_one(config_.method))
        move_cloud(cloud, move_.data(), state_.data(), input_.device(), stream_);
      else
        flow_particles(field_, rules_, scan(), state_.data(), cloud, stream_);
      cloud_moments({cloud, nullptr}, nullptr, true, state_.data(), scratch_, stream_);
    }
    finish_mean_state(rules_, state_.data(), stream_);
    copy_up(state_up_.data(), state_.data(), sizeof(FlowState), stream_);
  }
  void start_weighted_stages(const Particles& cloud) {
    update_gaussian();
    flow_particles(field_, rules_, scan(), state_.data(), cloud, stream_);
    const Weights weights{weight_.data(), cumulative_.data()};
    normalise_scan(bind_normalise(cloud, weights, config_.resample, weights_state_.data(), {},
                                  &input_.device()->scan_worth),
                   scratch_, stream_);
    cloud_moments({cloud, weight_.data()}, weights_state_.data(), true, state_.data(), scratch_, stream_);
    resample({cloud,
              view(*other_),
              weights,
              config_.resample.scheme,
              {},
              weights_state_.data(),
              ancestor_.data(),
              offspring_sum_.data(),
              remainder_sum_.data(),
              {}},
             input_.device(), scratch_, stream_);
    copy_up(weights_state_up_.data(), weights_state_.data(), sizeof(StepState), stream_);
  }
  void update_gaussian() {
    predict_mean(rules_, input_.device(), state_.data(), stream_);
    if (rules_.z_score > 0.0)
      reject_beams(field_, rules_, scan(), state_.data(), distance_.data(), keep_.data(), kept_.data(),
                   stream_);
    update_mean(field_, rules_, scan(), state_.data(), move_.data(), room_, stream_);
  }
  FlowScan scan() { return {input_.beams(), input_.device(), keep_.data(), kept_.data()}; }

  FlowBackendConfig config_;
  int device_;
  std::string device_name_;
  std::size_t capacity_;
  Stream stream_{};
  Scratch scratch_;
  FlowRules rules_;
  DistanceField field_;
  DeviceBuffer<DistancePair> table_;
  StepInputBuffer input_;
  DeviceBuffer<float> distance_, keep_, kept_;  // with a z score only
  Poses a_, b_;                                 // b_ for pfpf only, and so what belongs to weights
  Poses *now_ = &a_, *other_ = &b_;
  DeviceBuffer<float> log_weight_;
  DeviceBuffer<std::uint64_t> weight_, cumulative_, offspring_sum_, remainder_sum_;
  DeviceBuffer<std::uint32_t> ancestor_;
  DeviceBuffer<FlowState> state_;
  DeviceBuffer<CloudMove> move_;
  DeviceBuffer<StepState> weights_state_;
  UpdateRoom room_;
  HostBuffer<FlowState> state_up_;
  HostBuffer<StepState> weights_state_up_;
  Repeated steps_[2];  // by which poses are the current ones
};

}  // namespace

#if !defined(__CUDACC__)
std::unique_ptr<FlowBackend> make_flow_backend_on_host(const FlowBackendConfig& config) {
  return std::make_unique<CudaFlowBackend>(config, "kernels on the host");
}
#endif
}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
std::unique_ptr<FlowBackend> make_cuda_flow_backend(const FlowBackendConfig& config) {
  return std::make_unique<cuda::CudaFlowBackend>(config, cuda::usable_device(config.device));
}
#endif

}  // namespace parloc
