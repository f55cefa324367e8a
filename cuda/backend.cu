#include "common/filter/backend.h"

#include "common/filter/bins.h"
#include "common/map/distance_field.h"
#include "common/map/skip_field.h"
#include "cuda/host_map.h"
#include "cuda/stages.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

struct ParticleBuffer {
  DeviceBuffer<float> x, y, theta, log_weight;
  std::size_t count;
  explicit ParticleBuffer(std::size_t n) : count(n) {
    for (auto* b : {&x, &y, &theta, &log_weight}) b->reserve(n);
  }
  Particles view() const { return {x.data(), y.data(), theta.data(), log_weight.data(), count}; }
};

std::uint32_t power_of_two_above(std::uint64_t n) {
  std::uint32_t p = 1;
  while (p < n) p *= 2;
  return p;
}

class CudaBackend final : public Backend {
 public:
  CudaBackend(const BackendConfig& config, std::string device)
      : config_(config),
        device_(std::move(device)),
        count_(static_cast<std::size_t>(config.particles)),
        a_(count_),
        b_(count_) {
    stream_ = make_stream();
    scratch_.reserve(count_);
    weight_.reserve(count_);
    cumulative_.reserve(count_);
    ancestor_.reserve(count_);
    bins_.capacity = power_of_two_above(2 * count_);
    for (auto* b : {&bin_key_, &bin_weight_, &cluster_weight_}) b->reserve(bins_.capacity);
    bin_parent_.reserve(bins_.capacity);
    bin_slot_.reserve(count_);
    bins_ = {bin_key_.data(),    bin_weight_.data(), cluster_weight_.data(),
             bin_parent_.data(), bin_slot_.data(),   bins_.capacity};
    state_.from_host({StepState{}}, stream_);
    if (config.resample.scheme == ResampleScheme::residual) {
      offspring_sum_.reserve(count_);
      remainder_sum_.reserve(count_);
    }
    synchronise(stream_);
  }
  ~CudaBackend() override { free_stream(stream_); }

  std::string name() const override { return "cuda (" + device_ + ")"; }

  void set_map(const GridMap& map) override {
    map_ = map;
    if (config_.sensor.model == SensorModel::likelihood_field) {
      squared_distance_ = squared_distance_of(map);
    } else {
      skip_.from_host(skip_field_of(map, config_.sensor.unknown_blocks), stream_);
      synchronise(stream_);
    }
    map_.cells.clear();
  }

  void set_range_max(double range_max_m) override {
    if (config_.sensor.model != SensorModel::likelihood_field) return;
    field_.from_host(likelihood_table(squared_distance_, map_, range_max_m, config_.sensor), stream_);
    synchronise(stream_);
  }

  void upload(const ParticleSet& p) override {
    a_.x.from_host(p.x, stream_);
    a_.y.from_host(p.y, stream_);
    a_.theta.from_host(p.theta, stream_);
    a_.log_weight.from_host(p.log_weight, stream_);
    synchronise(stream_);
    now_ = &a_, other_ = &b_;
  }
  ParticleSet download() const override {
    return {now_->x.to_host(count_, stream_), now_->y.to_host(count_, stream_),
            now_->theta.to_host(count_, stream_), now_->log_weight.to_host(count_, stream_)};
  }

  void predict(const MotionStep& motion, RandomKey key) override {
    PARLOC_CUDA_NAMESPACE::predict({now_->view(), motion, key}, stream_);
  }

  void set_scan(const BeamTable& t) override {
    host_beams_ = t;  // stays alive until finish(): the copies below are asynchronous
    direction_x_.from_host(host_beams_.direction_x, stream_);
    direction_y_.from_host(host_beams_.direction_y, stream_);
    range_m_.from_host(host_beams_.range_m, stream_);
    short_density_.from_host(host_beams_.short_density, stream_);
    end_x_.from_host(host_beams_.end_x, stream_);
    end_y_.from_host(host_beams_.end_y, stream_);
  }

  std::vector<float> ray_trace() override {
    trace();
    return expected_m_.to_host(count_ * host_beams_.count, stream_);
  }

  void weight(bool fused) override {
    const bool stored = !fused && config_.sensor.model != SensorModel::likelihood_field;
    if (stored) trace();
    const std::int32_t stride = map_.width + 2;
    const LikelihoodField field{field_.size() > 0 ? field_.data() + stride + 1 : nullptr, map_.width,
                                map_.height, stride};
    const RayTraceArgs r = ray_args();
    PARLOC_CUDA_NAMESPACE::weight(
        {r.particles, r.beams, config_.sensor.model, static_cast<float>(config_.sensor.tempering), r.map,
         r.caster, r.fixed_step_cells, bind_gaussian(config_.sensor),
         bind_censored(config_.sensor, host_beams_.range_max_m), field, config_.sensor.lookup,
         stored ? expected_m_.data() : nullptr},
        stream_);
  }

  void normalise_scan() override {
    const double threshold = config_.resample.threshold;
    PARLOC_CUDA_NAMESPACE::normalise_scan(
        {now_->view(), weights_view(), threshold, threshold >= 1.0, state_.data()}, scratch_, stream_);
  }
  void estimate() override {
    PARLOC_CUDA_NAMESPACE::estimate(now_->view(), weights_view(), bins_, state_.data(), scratch_, stream_);
  }
  void resample(RandomKey key) override {
    PARLOC_CUDA_NAMESPACE::resample(
        {now_->view(), other_->view(), weights_view(), config_.resample.scheme, key, state_.data(),
         ancestor_.data(), offspring_sum_.data(), remainder_sum_.data()},
        scratch_, stream_);
    std::swap(now_, other_);
  }

  StepState finish() override { return state_.to_host(1, stream_)[0]; }
  std::vector<std::uint64_t> weights() const override { return weight_.to_host(count_, stream_); }
  std::vector<std::uint64_t> cumulative() const override { return cumulative_.to_host(count_, stream_); }
  std::vector<std::uint32_t> ancestors() const override { return ancestor_.to_host(count_, stream_); }

 private:
  void trace() {
    expected_m_.reserve(count_ * host_beams_.count);
    RayTraceArgs args = ray_args();
    args.expected_m = expected_m_.data();
    PARLOC_CUDA_NAMESPACE::ray_trace(args, stream_);
  }
  RayTraceArgs ray_args() const {
    const std::int32_t stride = map_.width + 2;
    const RayMap map{skip_.size() > 0 ? skip_.data() + stride + 1 : nullptr,
                     map_.width,
                     map_.height,
                     stride,
                     static_cast<float>(map_.resolution_m),
                     static_cast<float>(1.0 / map_.resolution_m)};
    const Beams beams{direction_x_.data(),   direction_y_.data(), range_m_.data(),
                      short_density_.data(), end_x_.data(),       end_y_.data(),
                      host_beams_.count,     host_beams_.hits,    host_beams_.range_max_m,
                      host_beams_.sensor_x,  host_beams_.sensor_y};
    return {
        now_->view(), map, beams, config_.sensor.caster, static_cast<float>(config_.sensor.fixed_step_cells),
        nullptr};
  }
  Weights weights_view() const { return {weight_.data(), cumulative_.data(), count_}; }

  BackendConfig config_;
  std::string device_;
  std::size_t count_;
  Stream stream_{};
  Scratch scratch_;
  GridMap map_;  // without its cells
  std::vector<std::uint32_t> squared_distance_;
  DeviceBuffer<std::uint8_t> skip_;
  DeviceBuffer<float> field_;
  BeamTable host_beams_;
  DeviceBuffer<float> direction_x_, direction_y_, range_m_, short_density_, end_x_, end_y_, expected_m_;
  ParticleBuffer a_, b_;
  ParticleBuffer *now_ = &a_, *other_ = &b_;
  DeviceBuffer<std::uint64_t> weight_, cumulative_, offspring_sum_, remainder_sum_;
  DeviceBuffer<std::uint32_t> ancestor_;
  BinTable bins_;
  DeviceBuffer<std::uint64_t> bin_key_, bin_weight_, cluster_weight_;
  DeviceBuffer<std::uint32_t> bin_parent_, bin_slot_;
  DeviceBuffer<StepState> state_;
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
    lines.push_back("cuda: " + std::string(p.name) + ", compute capability " + std::to_string(p.major) + "." +
                    std::to_string(p.minor) + ", " + std::to_string(p.totalGlobalMem >> 20) + " MiB");
  }
  if (lines.empty()) lines.push_back("cuda: built, but no device answers (no GPU, or no driver)");
  return lines;
}

std::unique_ptr<Backend> make_cuda_backend(const BackendConfig& config) {
  if (cuda_device_count() == 0)
    throw Error(ErrorKind::backend,
                "backend cuda: no CUDA device answers (no GPU, or no driver); use --backend cpu");
  cudaDeviceProp p{};
  PARLOC_CHECK(cudaGetDeviceProperties(&p, 0), "reading the device's properties");
  return std::make_unique<cuda::CudaBackend>(config, p.name);
}
#endif

}  // namespace parloc
