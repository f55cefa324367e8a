#include "common/flow/flow_backend.h"

#include <fmt/format.h>
#include <omp.h>

#include "common/filter/bind.h"
#include "common/flow/mean_update.h"
#include "common/map/blocking_cells.h"
#include "cpu/distance_field.h"
#include "cpu/flow_stages.h"
#include "cpu/poses.h"
#include "cpu/stages.h"

namespace parloc {
namespace {

class CpuFlowBackend final : public FlowBackend {
 public:
  explicit CpuFlowBackend(const FlowBackendConfig& config)
      : config_(config),
        now_(static_cast<std::size_t>(config.particles)),
        other_(weighs() ? now_.x.size() : 0),
        log_weight_(now_.x.size()),
        weight_(other_.x.size()),
        cumulative_(other_.x.size()),
        ancestor_(other_.x.size()) {
    workers_.threads = config.threads > 0 ? config.threads : omp_get_num_procs();
    workers_.reserve(now_.x.size());
    if (weighs() && config.resample.scheme == ResampleScheme::residual) {
      offspring_sum_.resize(now_.x.size());
      remainder_sum_.resize(now_.x.size());
    }
  }

  std::string name() const override {
    return fmt::format("cpu ({}, {} thread{})", cpu::simd_name(cpu::simd_level()), workers_.threads,
                       workers_.threads == 1 ? "" : "s");
  }

  void set_map(const GridMap& map) override {
    const std::vector<std::uint8_t> occupied = blocking_cells(map, false);
    const std::vector<std::uint32_t> squared =
        cpu::squared_distance_field(occupied.data(), map.width, map.height, workers_.threads);
    cpu::distance_table(squared, map.width, map.height, workers_, table_);
    rules_ = bind_flow_rules(config_.flow, config_.method, map.resolution_m);
    field_ = {
        {table_.data(), map.width, map.height}, rules_.interpolation, rules_.cap_cells, map.resolution_m};
  }

  void start(const ParticleSet& p, const PoseGaussian& gaussian) override {
    now_.count = other_.count = static_cast<std::uint32_t>(p.x.size());
    std::copy(p.x.begin(), p.x.end(), now_.x.begin());
    std::copy(p.y.begin(), p.y.end(), now_.y.begin());
    std::copy(p.theta.begin(), p.theta.end(), now_.theta.begin());
    std::copy(p.log_weight.begin(), p.log_weight.end(), log_weight_.begin());
    state_ = {};
    state_.posterior = gaussian;
    weights_state_ = {};
  }
  ParticleSet download() const override { return {now_.x, now_.y, now_.theta, log_weight_}; }

  const FlowState& step(const MotionStep& motion, RandomKey key, const BeamTable* scan) override {
    scan_.set(scan);
    if (is_kalman(config_.method)) {
      update_gaussian(motion);
    } else if (weighs()) {
      weighted_step(motion, key);
    } else {
      cpu::predict({view(now_), motion, key}, workers_);
      cpu::cloud_moments({view(now_), nullptr}, total(), rules_.prior == FlowPrior::sample, state_.cloud,
                         workers_);
      update_gaussian(motion);
      if (state_.skip == FlowSkip::none && moves_as_one(config_.method))
        cpu::move_cloud(view(now_), move_, key, workers_);
      if (config_.method == FlowMethod::ledh)
        cpu::flow_particles(field_, rules_, scan_, motion, key, state_, view(now_), workers_);
      cpu::cloud_moments({view(now_), nullptr}, total(), true, state_.cloud, workers_);
    }
    finish_state(state_, rules_);
    return state_;
  }
  const StepState& weights_state() const override { return weights_state_; }

 private:
  bool weighs() const { return config_.method == FlowMethod::pfpf; }
  double total() const { return static_cast<double>(now_.count); }
  Particles view(cpu::Poses& p) {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), &p.count, p.x.size()};
  }
  void update_gaussian(const MotionStep& motion) {
    cpu::predict_mean(rules_, motion, state_);
    cpu::reject_beams(field_, rules_, state_, scan_, notes_);
    cpu::update_mean(field_, rules_, scan_, state_, move_, notes_);
  }
  /// Particles propose for themselves; then as in any particle filter.
  void weighted_step(const MotionStep& motion, RandomKey key) {
    update_gaussian(motion);
    cpu::flow_particles(field_, rules_, scan_, motion, key, state_, view(now_), workers_);
    const Weights weights{weight_.data(), cumulative_.data()};
    cpu::normalise_scan(
        bind_normalise(view(now_), weights, config_.resample, &weights_state_, {}, &scan_worth_), workers_);
    cpu::cloud_moments({view(now_), weight_.data()}, static_cast<double>(weights_state_.total), true,
                       state_.cloud, workers_);
    cpu::resample({view(now_),
                   view(other_),
                   weights,
                   config_.resample.scheme,
                   key,
                   &weights_state_,
                   ancestor_.data(),
                   offspring_sum_.data(),
                   remainder_sum_.data(),
                   {}},
                  workers_);
    std::swap(now_, other_);
  }

  FlowBackendConfig config_;
  cpu::Workers workers_;
  FlowRules rules_;
  std::vector<DistancePair> table_;
  DistanceField field_;
  cpu::PaddedScan scan_;
  cpu::BeamNotes notes_;
  cpu::Poses now_, other_;  // the other one only for pfpf, and so what follows
  std::vector<float> log_weight_;
  std::vector<std::uint64_t> weight_, cumulative_;
  std::vector<std::uint32_t> ancestor_;
  std::vector<std::uint64_t> offspring_sum_, remainder_sum_;  // residual scheme only
  float scan_worth_ = 0.0f;                                   // no running means of likelihoods
  FlowState state_;
  CloudMove move_;
  StepState weights_state_;
};

}  // namespace

std::unique_ptr<FlowBackend> make_cpu_flow_backend(const FlowBackendConfig& config) {
  return std::make_unique<CpuFlowBackend>(config);
}

}  // namespace parloc
