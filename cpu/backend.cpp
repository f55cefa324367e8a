#include "common/filter/backend.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <fstream>

#include "common/filter/beam_votes.h"
#include "common/filter/bind.h"
#include "common/filter/bins.h"
#include "common/filter/start.h"
#include "common/map/blocking_cells.h"
#include "common/map/skip_field.h"
#include "common/map/wall_index.h"
#include "cpu/distance_field.h"
#include "cpu/likelihood_field.h"
#include "cpu/poses.h"
#include "cpu/stages.h"

namespace parloc {
namespace {

/// 4 M cells, 100 x 100 m at 5 cm. By sector is worth it even out of the caches: 13 times on the office floor
/// (25 MB).
constexpr std::size_t kMostSkipBytes = std::size_t{128} << 20;

class CpuBackend final : public Backend {
 public:
  explicit CpuBackend(const BackendConfig& config)
      : config_(config),
        now_(static_cast<std::size_t>(config.particles)),
        other_(static_cast<std::size_t>(config.particles)),
        log_weight_(now_.x.size()),
        weight_(now_.x.size(), 1),
        cumulative_(now_.x.size()),
        ancestor_(now_.x.size()),
        bin_capacity_(bin_capacity(now_.x.size())),
        bin_key_(bin_capacity_),
        bin_weight_(bin_capacity_),
        bin_parent_(bin_capacity_),
        bin_slot_(now_.x.size()),
        bin_used_(now_.x.size()) {
    for (std::uint32_t slot = 0; slot < bin_capacity_; ++slot) bin_clear(bins_view(), slot);
    workers_.reserve(now_.x.size());
    state_.count = state_.next_count = now_.count;
    workers_.threads = config.threads > 0 ? config.threads : omp_get_num_procs();
    if (config.resample.scheme == ResampleScheme::residual) {
      offspring_sum_.resize(now_.x.size());
      remainder_sum_.resize(now_.x.size());
    }
  }

  std::string name() const override {
    return fmt::format("cpu ({}, {} thread{})", cpu::simd_name(cpu::simd_level()), workers_.threads,
                       workers_.threads == 1 ? "" : "s");
  }

  void set_map(const GridMap& map) override {
    map_ = map;
    if (config_.injects()) free_cells_ = free_cells(map);
    if (!casts_rays(config_.sensor.model)) {
      const std::vector<std::uint8_t> occupied = blocking_cells(map, false);
      squared_distance_ =
          cpu::squared_distance_field(occupied.data(), map.width, map.height, workers_.threads);
    } else {
      walls_ = map.walls.empty() ? WallIndex{} : index_walls(map);
      const std::vector<std::uint8_t> blocks =
          map.walls.empty() ? blocking_cells(map, config_.sensor.unknown_blocks) : std::move(walls_.blocks);
      skip_ = skip_field(blocks.data(), map.width, map.height, kMostSkipBytes);
    }
    map_.walls.clear();
    map_.walls.shrink_to_fit();
    map_.cells.clear();
    map_.cells.shrink_to_fit();
  }

  void set_range_max(double range_max_m) override {
    if (casts_rays(config_.sensor.model)) return;
    const DistanceLikelihood likelihood = bind_distance(config_.sensor, map_.resolution_m, range_max_m);
    field_unit_nat_ = likelihood.unit_nat();
    cpu::likelihood_table(squared_distance_, map_.width, map_.height, likelihood, workers_, field_);
  }

  void upload(const ParticleSet& p) override {
    check_upload(p, config_);
    now_.count = other_.count = static_cast<std::uint32_t>(p.x.size());
    std::copy(p.x.begin(), p.x.end(), now_.x.begin());
    std::copy(p.y.begin(), p.y.end(), now_.y.begin());
    std::copy(p.theta.begin(), p.theta.end(), now_.theta.begin());
    std::copy(p.log_weight.begin(), p.log_weight.end(), log_weight_.begin());
    state_ = {};
    state_.count = state_.next_count = now_.count;
  }
  ParticleSet download() const override {
    return {first(now_.x, now_.count), first(now_.y, now_.count), first(now_.theta, now_.count),
            first(log_weight_, now_.count)};
  }

  void predict(const MotionStep& motion, RandomKey key) override {
    scan_worth_ = 0.0f;
    cpu::predict({view(now_), motion, key}, workers_);
  }
  void set_scan(const BeamTable& beams) override {
    beams_ = beams;
    scan_worth_ = bind_scan_worth(config_.sensor, beams);
    scatter_beams(beams, scattered_);  // so that a particle's first beams tell most
  }

  std::vector<float> ray_trace() override {
    std::vector<float> expected_m(now_.count * beams_.count);
    RayTraceArgs args = ray_args(beams_);
    args.expected_m = expected_m.data();
    cpu::ray_trace(args, workers_);
    return expected_m;
  }

  void weight(bool fused) override {
    const bool casts = casts_rays(config_.sensor.model);
    RayTraceArgs rays = ray_args(casts && fused ? scattered_ : beams_);
    if (casts && !fused) {
      expected_m_ = ray_trace();
      rays.expected_m = expected_m_.data();
    }
    const std::uint32_t* table = field_.empty() ? nullptr : field_.data();
    const std::uint32_t* distance = squared_distance_.empty() ? nullptr : squared_distance_.data();
    const WeightArgs args = bind_weight(rays, bind_field(table, field_unit_nat_, config_.sensor, map_),
                                        config_.sensor, {distance, votes_view(), &state_});
    if (needs_beam_votes(args)) cpu::beam_votes(args, workers_);
    cpu::weight(args, workers_);
  }

  void normalise_scan() override {
    cpu::normalise_scan(bind_normalise(view(now_), weights_view(), config_.resample, &state_,
                                       bind_recovery(config_.recovery), &scan_worth_),
                        workers_);
  }

  void estimate() override { cpu::estimate(view(now_), weights_view(), bins_view(), &state_, workers_); }

  void adapt(RandomKey key, bool all) override {
    if (!config_.adapts()) return;
    const KldRule usual = bind_kld(config_.kld, config_.min_particles, config_.particles);
    const KldRule rule = all ? rule_for_all(usual) : usual;
    cpu::adapt({view(now_), view(other_), weights_view(), rule, free_space(), key, bins_view(), &state_},
               workers_);
  }

  void resample(RandomKey key) override {
    cpu::resample({view(now_), view(other_), weights_view(), config_.resample.scheme, key, &state_,
                   ancestor_.data(), offspring_sum_.data(), remainder_sum_.data(), free_space()},
                  workers_);
    std::swap(now_, other_);
  }

  StepState finish() override { return state_; }
  std::vector<std::uint64_t> weights() const override { return first(weight_, state_.count); }
  std::vector<std::uint64_t> cumulative() const override { return first(cumulative_, state_.count); }
  std::vector<std::uint32_t> ancestors() const override { return first(ancestor_, now_.count); }

 private:
  template <class T>
  static std::vector<T> first(const std::vector<T>& all, std::uint32_t count) {
    return std::vector<T>(all.begin(), all.begin() + count);
  }
  FreeSpace free_space() const { return bind_free_space(free_cells_.data(), free_cells_.size(), map_); }
  RayTraceArgs ray_args(const BeamTable& beams) {
    const RayMap map =
        bind_ray_map(skip_.lines.empty() ? nullptr : skip_.lines.data(), skip_.plane, map_, walls_.view());
    return bind_rays(view(now_), map, bind_beams(beams), config_.sensor);
  }
  /// Log-weights stay in their slots, so that one array serves both buffers of poses.
  Particles view(cpu::Poses& p) {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), &p.count, p.x.size()};
  }
  BeamVotes votes_view() { return {votes_.data(), votes_.data() + kMaxBeams, share_.data()}; }
  Weights weights_view() { return {weight_.data(), cumulative_.data()}; }
  BinTable bins_view() {
    return {bin_key_.data(),  bin_weight_.data(), bin_parent_.data(), bin_slot_.data(),
            bin_used_.data(), &bins_used_,        bin_capacity_};
  }

  BackendConfig config_;
  cpu::Workers workers_;
  GridMap map_;  // without its cells
  SkipField skip_;
  WallIndex walls_;
  std::vector<std::uint32_t> squared_distance_;
  std::vector<std::uint32_t> field_;
  float field_unit_nat_ = 0;
  BeamTable beams_, scattered_;
  float scan_worth_ = 0.0f;
  std::vector<std::uint32_t> free_cells_;  // only where particles are injected
  std::vector<std::uint64_t> votes_ = std::vector<std::uint64_t>(2 * kMaxBeams);  // zero between the steps
  std::vector<float> share_ = std::vector<float>(kMaxBeams);
  cpu::Poses now_, other_;
  std::vector<float> log_weight_;
  std::vector<std::uint64_t> weight_, cumulative_;
  std::vector<std::uint32_t> ancestor_;
  std::uint32_t bin_capacity_;
  std::vector<std::uint64_t> bin_key_, bin_weight_;
  std::vector<std::uint32_t> bin_parent_, bin_slot_, bin_used_;
  std::uint64_t bins_used_ = 0;
  std::vector<std::uint64_t> offspring_sum_, remainder_sum_;  // residual scheme only
  std::vector<float> expected_m_;                             // unfused reference only
  StepState state_;
};

}  // namespace

std::unique_ptr<Backend> make_cpu_backend(const BackendConfig& config) {
  return std::make_unique<CpuBackend>(config);
}

std::string describe_cpu() {
  std::string model = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0 && line.find(':') != std::string::npos) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("cpu: {}, {} cores, using {}", model, omp_get_num_procs(),
                     cpu::simd_name(cpu::simd_level()));
}

}  // namespace parloc
