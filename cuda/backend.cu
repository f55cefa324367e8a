#include "common/filter/backend.h"

#include <bit>
#include <map>

#include "common/filter/beam_votes.h"
#include "common/filter/bind.h"
#include "common/filter/bins.h"
#include "common/filter/start.h"
#include "common/map/blocking_cells.h"
#include "common/map/skip_field.h"
#include "common/map/wall_index.h"
#include "cuda/device.h"
#include "cuda/distance_field.h"
#include "cuda/likelihood_field.h"
#include "cuda/poses.h"
#include "cuda/stages.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

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

/// Stages are only noted when they are asked for; finish() starts them all, as one graph once the same step
/// has been seen before.
class CudaBackend final : public Backend {
 public:
  CudaBackend(const BackendConfig& config, std::string device_name)
      : config_(config),
        device_(selected(config.device)),  // before anything is allocated
        device_name_(std::move(device_name)),
        capacity_(static_cast<std::size_t>(config.particles)),
        a_(capacity_),
        b_(capacity_) {
    stream_ = make_stream();
    scratch_.reserve(capacity_);
    log_weight_.reserve(capacity_);
    weight_.reserve(capacity_);
    cumulative_.reserve(capacity_);
    ancestor_.reserve(capacity_);
    if (config.adapts()) first_of_bin_.reserve(capacity_);
    bins_.capacity = bin_capacity(capacity_);
    for (auto* b : {&bin_key_, &bin_weight_}) b->reserve(bins_.capacity);
    bin_parent_.reserve(bins_.capacity);
    bin_slot_.reserve(capacity_);
    bin_used_.reserve(capacity_);
    bins_used_.reserve(1);
    bins_ = {bin_key_.data(),  bin_weight_.data(), bin_parent_.data(), bin_slot_.data(),
             bin_used_.data(), bins_used_.data(),  bins_.capacity};
    clear_all_bins(bins_, stream_);
    state_up_.reserve(1);
    start_with(static_cast<std::uint32_t>(capacity_));
    votes_.from_host(std::vector<std::uint64_t>(2 * kMaxBeams), stream_);
    share_.reserve(kMaxBeams);
    if (config.resample.scheme == ResampleScheme::residual) {
      offspring_sum_.reserve(capacity_);
      remainder_sum_.reserve(capacity_);
    }
    synchronise(stream_);
  }
  ~CudaBackend() override {
    steps_.clear();
    free_stream(stream_);
  }

  std::string name() const override { return "cuda (" + device_name_ + ")"; }

  void set_map(const GridMap& map) override {
    use_device();
    run_planned();
    steps_.clear();  // they know the old map's place
    map_ = map;
    if (config_.injects()) {
      const std::vector<std::uint32_t> cells = free_cells(map);
      free_cells_.from_host(cells, stream_);
      free_count_ = cells.size();
      synchronise(stream_);
    }
    const bool field = !casts_rays(config_.sensor.model);
    const std::vector<std::uint8_t> blocks = blocking_cells(map, !field && config_.sensor.unknown_blocks);
    if (field) {
      DeviceBuffer<std::uint8_t> occupied;
      occupied.from_host(blocks, stream_);
      squared_distance_.reserve(map.size());
      squared_distance_field(occupied.data(), map.width, map.height, squared_distance_.data(), stream_);
    } else if (!map.walls.empty()) {
      const WallIndex index = index_walls(map);
      skip_.from_host(skip_field(index.blocks.data(), map.width, map.height, 0).lines, stream_);
      walls_.from_host(index.walls, stream_);
      wall_ids_.from_host(index.ids, stream_);
      wall_first_.from_host(index.first, stream_);
      synchronise(stream_);
    } else {
      // One plane: a map of usual size then fits the first-level cache of a multiprocessor.
      skip_.from_host(skip_field(blocks.data(), map.width, map.height, 0).lines, stream_);
      synchronise(stream_);
    }
    wall_count_ = static_cast<std::uint32_t>(map.walls.size());
    map_.walls.clear();
    map_.walls.shrink_to_fit();
    map_.cells.clear();
    map_.cells.shrink_to_fit();
  }

  void set_range_max(double range_max_m) override {
    if (casts_rays(config_.sensor.model)) return;
    use_device();
    run_planned();
    const DistanceLikelihood likelihood = bind_distance(config_.sensor, map_.resolution_m, range_max_m);
    if (likelihood.unit_nat() != field_unit_nat_) steps_.clear();  // they know the old one
    field_unit_nat_ = likelihood.unit_nat();
    field_.reserve(table_size(map_.width, map_.height));
    likelihood_table(squared_distance_.data(), map_.width, map_.height, likelihood, field_.data(), stream_);
  }

  void upload(const ParticleSet& p) override {
    check_upload(p, config_);
    use_device();
    run_planned();
    a_.x.from_host(p.x, stream_);
    a_.y.from_host(p.y, stream_);
    a_.theta.from_host(p.theta, stream_);
    log_weight_.from_host(p.log_weight, stream_);
    start_with(static_cast<std::uint32_t>(p.x.size()));
    synchronise(stream_);
    now_ = &a_, other_ = &b_;
  }
  ParticleSet download() const override {
    expect_finished();
    return {now_->x.to_host(now_count_, stream_), now_->y.to_host(now_count_, stream_),
            now_->theta.to_host(now_count_, stream_), log_weight_.to_host(now_count_, stream_)};
  }

  void predict(const MotionStep& motion, RandomKey key) override {
    plan(kPredict);
    use_key(key);
    input_.host().motion = motion;
    input_.host().scan_worth = 0.0f;
  }

  void set_scan(const BeamTable& t) override {
    use_device();
    if (planned_ >= kWeight) run_planned();
    input_.host().models = bind_ray_models(config_.sensor, t.range_max_m);
    input_.host().tempering = bind_tempering(config_.sensor, t);
    input_.host().scan_worth = bind_scan_worth(config_.sensor, t);
    if (input_.set_scan(t)) steps_.clear();  // they know the arrays' old place
  }

  std::vector<float> ray_trace() override {
    run_planned();
    reserve_expected();
    input_.copy_to_device(stream_);
    trace();
    return expected_m_.to_host(now_count_ * input_.host().scan.count, stream_);
  }

  void weight(bool fused) override {
    const bool stored = !fused && casts_rays(config_.sensor.model);
    plan(stored ? kWeightUnfused : kWeight);
    if (stored) reserve_expected();
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
    return *state_up_.data();
  }
  std::vector<std::uint64_t> weights() const override { return read(weight_, weighed_count_); }
  std::vector<std::uint64_t> cumulative() const override { return read(cumulative_, weighed_count_); }
  std::vector<std::uint32_t> ancestors() const override { return read(ancestor_, now_count_); }

 private:
  /// A thread may drive several filters, each on its own device.
  void use_device() const { select_device(device_); }

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
    if (planned_ == 0) return;
    use_device();
    const unsigned which_poses = now_ == &a_ ? 0 : 2 * kResample;
    steps_[planned_ + which_poses].run(stream_, [this] { start_stages(); });
    synchronise(stream_);
    weighed_count_ = state_up_.data()->count;
    if ((planned_ & kResample) != 0) {
      std::swap(now_, other_);
      now_count_ = state_up_.data()->next_count;
    }
    planned_ = 0;
  }

  /// So many particles are in the buffers; there has been no step.
  void start_with(std::uint32_t count) {
    now_count_ = weighed_count_ = count;
    StepState state;
    state.count = state.next_count = count;
    *state_up_.data() = state;
    state_.from_host({state}, stream_);
    for (Poses* p : {&a_, &b_}) p->live.from_host({count}, stream_);
    synchronise(stream_);
  }

  /// Everything that differs from the last such step is in input_, so this may be recorded.
  void start_stages() {
    namespace stage = PARLOC_CUDA_NAMESPACE;
    const auto asked = [this](Stage s) { return (planned_ & s) != 0; };
    input_.copy_to_device(stream_);
    if (asked(kPredict)) stage::predict(view(*now_), input_.device(), stream_);
    if (asked(kWeightUnfused)) trace();
    if (asked(kWeight) || asked(kWeightUnfused)) {
      RayTraceArgs rays = ray_args();
      rays.expected_m = asked(kWeightUnfused) ? expected_m_.data() : nullptr;
      const LikelihoodField field = bind_field(field_.data(), field_unit_nat_, config_.sensor, map_);
      const WeightArgs args =
          bind_weight(rays, field, config_.sensor, {squared_distance_.data(), votes_view(), state_.data()});
      if (needs_beam_votes(args)) stage::beam_votes(args, input_.device(), stream_);
      stage::weight(args, input_.device(), stream_);
    }
    if (asked(kNormalise))
      stage::normalise_scan(bind_normalise(view(*now_), weights_view(), config_.resample, state_.data(),
                                           bind_recovery(config_.recovery), &input_.device()->scan_worth),
                            scratch_, stream_);
    if (asked(kEstimate))
      stage::estimate(view(*now_), weights_view(), bins_, state_.data(), scratch_, stream_);
    if (asked(kAdapt)) stage::adapt(adapt_args(), input_.device(), scratch_, stream_);
    if (asked(kResample)) stage::resample(resample_args(), input_.device(), scratch_, stream_);
    copy_up(state_up_.data(), state_.data(), sizeof(StepState), stream_);
  }

  void expect_finished() const {
    if (planned_ != 0) throw Error(ErrorKind::internal, "Backend: expected finish() before reading results");
  }
  template <class T>
  std::vector<T> read(const DeviceBuffer<T>& buffer, std::size_t count) const {
    expect_finished();
    use_device();
    return buffer.to_host(count, stream_);
  }

  void reserve_expected() {
    use_device();
    const std::size_t size = capacity_ * input_.host().scan.count;
    if (size > expected_m_.size()) steps_.clear();  // they know the old place
    expected_m_.reserve(size);
  }
  void trace() {
    RayTraceArgs args = ray_args();
    args.expected_m = expected_m_.data();
    PARLOC_CUDA_NAMESPACE::ray_trace(args, input_.device(), stream_);
  }
  RayTraceArgs ray_args() {
    const Walls walls{walls_.data(), wall_ids_.data(), wall_first_.data(), wall_count_};
    return bind_rays(view(*now_), bind_ray_map(skip_.data(), 0, map_, walls), input_.beams(), config_.sensor);
  }
  AdaptArgs adapt_args() const {
    const KldRule rule = bind_kld(config_.kld, config_.min_particles, config_.particles);
    return {view(*now_), view(*other_), weights_view(),      rule, free_space(), {},
            bins_,       state_.data(), first_of_bin_.data()};
  }
  ResampleArgs resample_args() const {
    return {view(*now_),   view(*other_),    weights_view(),        config_.resample.scheme, {},
            state_.data(), ancestor_.data(), offspring_sum_.data(), remainder_sum_.data(),   free_space()};
  }
  FreeSpace free_space() const { return bind_free_space(free_cells_.data(), free_count_, map_); }
  /// Log-weights stay in their slots, so that one array serves both buffers of poses.
  Particles view(const Poses& p) const {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), p.live.data(), capacity_};
  }
  BeamVotes votes_view() const { return {votes_.data(), votes_.data() + kMaxBeams, share_.data()}; }
  Weights weights_view() const { return {weight_.data(), cumulative_.data()}; }

  BackendConfig config_;
  int device_;
  std::string device_name_;
  std::size_t capacity_;
  std::size_t now_count_ = 0, weighed_count_ = 0;  // as the device has them, after finish()
  Stream stream_{};
  Scratch scratch_;
  GridMap map_;  // without its cells
  DeviceBuffer<std::uint32_t> squared_distance_;
  DeviceBuffer<std::uint8_t> skip_;
  DeviceBuffer<Wall> walls_;
  DeviceBuffer<std::uint32_t> wall_ids_, wall_first_;
  std::uint32_t wall_count_ = 0;
  DeviceBuffer<std::uint32_t> field_;
  float field_unit_nat_ = 0;
  DeviceBuffer<std::uint32_t> free_cells_;  // only where particles are injected
  std::size_t free_count_ = 0;
  StepInputBuffer input_;
  DeviceBuffer<std::uint64_t> votes_;  // zero between the steps
  DeviceBuffer<float> share_;
  DeviceBuffer<float> expected_m_;  // unfused reference only
  Poses a_, b_;
  DeviceBuffer<float> log_weight_;
  Poses *now_ = &a_, *other_ = &b_;
  DeviceBuffer<std::uint64_t> weight_, cumulative_, first_of_bin_, offspring_sum_, remainder_sum_;
  DeviceBuffer<std::uint32_t> ancestor_;
  BinTable bins_;
  DeviceBuffer<std::uint64_t> bin_key_, bin_weight_, bins_used_;
  DeviceBuffer<std::uint32_t> bin_parent_, bin_slot_, bin_used_;
  DeviceBuffer<StepState> state_;
  HostBuffer<StepState> state_up_;
  unsigned planned_ = 0;                // sum of Stage
  std::map<unsigned, Repeated> steps_;  // by planned_ and by which poses are the current ones
};

}  // namespace

#if !defined(__CUDACC__)
std::unique_ptr<Backend> make_backend_on_host(const BackendConfig& config) {
  return std::make_unique<CudaBackend>(config, "kernels on the host");
}
#endif
}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
int cuda_device_count() {
  int count = 0;
  if (cudaGetDeviceCount(&count) != cudaSuccess) {
    (void)cudaGetLastError();
    return 0;
  }
  return count;
}

std::vector<std::string> describe_cuda_devices() {
  std::vector<std::string> lines;
  for (int d = 0; d < cuda_device_count(); ++d) {
    cudaDeviceProp p{};
    PARLOC_CHECK(cudaGetDeviceProperties(&p, d), "reading a device's properties");
    lines.push_back("cuda " + std::to_string(d) + ": " + std::string(p.name) + ", compute capability " +
                    std::to_string(p.major) + "." + std::to_string(p.minor) + ", " +
                    std::to_string(p.totalGlobalMem >> 20) + " MiB");
  }
  if (lines.empty()) lines.push_back("cuda: built, but no device answers (no GPU, or no driver)");
  return lines;
}

std::unique_ptr<Backend> make_cuda_backend(const BackendConfig& config) {
  return std::make_unique<cuda::CudaBackend>(config, cuda::usable_device(config.device));
}
#endif

}  // namespace parloc
