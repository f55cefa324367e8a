#include "common/filter/backend.h"

#include <bit>

#include "common/filter/bind.h"
#include "common/filter/bins.h"
#include "common/map/blocking_cells.h"
#include "common/map/skip_field.h"
#include "cuda/distance_field.h"
#include "cuda/likelihood_field.h"
#include "cuda/stages.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

struct Poses {
  DeviceBuffer<float> x, y, theta;
  explicit Poses(std::size_t n) {
    for (auto* b : {&x, &y, &theta}) b->reserve(n);
  }
};

int selected(int device) {
  select_device(device);
  return device;
}

class CudaBackend final : public Backend {
 public:
  CudaBackend(const BackendConfig& config, std::string device_name)
      : config_(config),
        device_(selected(config.device)),  // before anything is allocated
        device_name_(std::move(device_name)),
        count_(static_cast<std::size_t>(config.particles)),
        a_(count_),
        b_(count_) {
    stream_ = make_stream();
    scratch_.reserve(count_);
    log_weight_.reserve(count_);
    weight_.reserve(count_);
    cumulative_.reserve(count_);
    ancestor_.reserve(count_);
    bins_.capacity = static_cast<std::uint32_t>(std::bit_ceil(2 * count_));
    for (auto* b : {&bin_key_, &bin_weight_}) b->reserve(bins_.capacity);
    bin_parent_.reserve(bins_.capacity);
    bin_slot_.reserve(count_);
    bin_used_.reserve(count_);
    bins_used_.reserve(1);
    bins_ = {bin_key_.data(),  bin_weight_.data(), bin_parent_.data(), bin_slot_.data(),
             bin_used_.data(), bins_used_.data(),  bins_.capacity};
    clear_all_bins(bins_, stream_);
    state_.from_host({StepState{}}, stream_);
    if (config.resample.scheme == ResampleScheme::residual) {
      offspring_sum_.reserve(count_);
      remainder_sum_.reserve(count_);
    }
    synchronise(stream_);
  }
  ~CudaBackend() override { free_stream(stream_); }

  std::string name() const override { return "cuda (" + device_name_ + ")"; }

  void set_map(const GridMap& map) override {
    use_device();
    map_ = map;
    const bool field = config_.sensor.model == SensorModel::likelihood_field;
    const std::vector<std::uint8_t> blocks = blocking_cells(map, !field && config_.sensor.unknown_blocks);
    if (field) {
      DeviceBuffer<std::uint8_t> occupied;
      occupied.from_host(blocks, stream_);
      squared_distance_.reserve(map.size());
      squared_distance_field(occupied.data(), map.width, map.height, squared_distance_.data(), stream_);
    } else {
      // One plane: a map of usual size then fits the first-level cache of a multiprocessor.
      skip_.from_host(skip_field(blocks.data(), map.width, map.height, 0).lines, stream_);
      synchronise(stream_);
    }
    map_.cells.clear();
    map_.cells.shrink_to_fit();
  }

  void set_range_max(double range_max_m) override {
    if (config_.sensor.model != SensorModel::likelihood_field) return;
    use_device();
    field_.reserve((static_cast<std::size_t>(map_.width) + 2) * (static_cast<std::size_t>(map_.height) + 2));
    likelihood_table(squared_distance_.data(), map_.width, map_.height,
                     bind_distance(config_.sensor, map_.resolution_m, range_max_m), field_.data(), stream_);
  }

  void upload(const ParticleSet& p) override {
    use_device();
    a_.x.from_host(p.x, stream_);
    a_.y.from_host(p.y, stream_);
    a_.theta.from_host(p.theta, stream_);
    log_weight_.from_host(p.log_weight, stream_);
    synchronise(stream_);
    now_ = &a_, other_ = &b_;
  }
  ParticleSet download() const override {
    return {now_->x.to_host(count_, stream_), now_->y.to_host(count_, stream_),
            now_->theta.to_host(count_, stream_), log_weight_.to_host(count_, stream_)};
  }

  void predict(const MotionStep& motion, RandomKey key) override {
    use_device();
    PARLOC_CUDA_NAMESPACE::predict({view(*now_), motion, key}, stream_);
  }

  void set_scan(const BeamTable& t) override {
    use_device();
    host_beams_ = t;  // stays alive until finish(): the copies below are asynchronous
    direction_x_.from_host(host_beams_.direction_x, stream_);
    direction_y_.from_host(host_beams_.direction_y, stream_);
    range_m_.from_host(host_beams_.range_m, stream_);
    short_density_.from_host(host_beams_.short_density, stream_);
    end_x_.from_host(host_beams_.end_x, stream_);
    end_y_.from_host(host_beams_.end_y, stream_);
  }

  std::vector<float> ray_trace() override {
    use_device();
    trace();
    return expected_m_.to_host(count_ * host_beams_.count, stream_);
  }

  void weight(bool fused) override {
    use_device();
    const bool stored = !fused && config_.sensor.model != SensorModel::likelihood_field;
    if (stored) trace();
    RayTraceArgs rays = ray_args();
    rays.expected_m = stored ? expected_m_.data() : nullptr;
    PARLOC_CUDA_NAMESPACE::weight(bind_weight(rays, bind_field(field_.data(), map_), config_.sensor),
                                  stream_);
  }

  void normalise_scan() override {
    use_device();
    PARLOC_CUDA_NAMESPACE::normalise_scan(
        bind_normalise(view(*now_), weights_view(), config_.resample, state_.data()), scratch_, stream_);
  }
  void estimate() override {
    use_device();
    PARLOC_CUDA_NAMESPACE::estimate(view(*now_), weights_view(), bins_, state_.data(), scratch_, stream_);
  }
  void resample(RandomKey key) override {
    use_device();
    PARLOC_CUDA_NAMESPACE::resample(
        {view(*now_), view(*other_), weights_view(), config_.resample.scheme, key, state_.data(),
         ancestor_.data(), offspring_sum_.data(), remainder_sum_.data()},
        scratch_, stream_);
    std::swap(now_, other_);
  }

  StepState finish() override { return state_.to_host(1, stream_)[0]; }
  std::vector<std::uint64_t> weights() const override { return weight_.to_host(count_, stream_); }
  std::vector<std::uint64_t> cumulative() const override { return cumulative_.to_host(count_, stream_); }
  std::vector<std::uint32_t> ancestors() const override { return ancestor_.to_host(count_, stream_); }

 private:
  /// A thread may drive several filters, each on its own device.
  void use_device() const { select_device(device_); }
  void trace() {
    expected_m_.reserve(count_ * host_beams_.count);
    RayTraceArgs args = ray_args();
    args.expected_m = expected_m_.data();
    PARLOC_CUDA_NAMESPACE::ray_trace(args, stream_);
  }
  RayTraceArgs ray_args() const {
    const Beams beams{direction_x_.data(),   direction_y_.data(), range_m_.data(),
                      short_density_.data(), end_x_.data(),       end_y_.data(),
                      host_beams_.count,     host_beams_.hits,    host_beams_.range_max_m,
                      host_beams_.sensor_x,  host_beams_.sensor_y};
    return bind_rays(view(*now_), bind_ray_map(skip_.data(), 0, map_), beams, config_.sensor);
  }
  /// Log-weights stay in their slots, so that one array serves both buffers of poses.
  Particles view(const Poses& p) const {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), count_};
  }
  Weights weights_view() const { return {weight_.data(), cumulative_.data(), count_}; }

  BackendConfig config_;
  int device_;
  std::string device_name_;
  std::size_t count_;
  Stream stream_{};
  Scratch scratch_;
  GridMap map_;  // without its cells
  DeviceBuffer<std::uint32_t> squared_distance_;
  DeviceBuffer<std::uint8_t> skip_;
  DeviceBuffer<float> field_;
  BeamTable host_beams_;
  DeviceBuffer<float> direction_x_, direction_y_, range_m_, short_density_, end_x_, end_y_, expected_m_;
  Poses a_, b_;
  DeviceBuffer<float> log_weight_;
  Poses *now_ = &a_, *other_ = &b_;
  DeviceBuffer<std::uint64_t> weight_, cumulative_, offspring_sum_, remainder_sum_;
  DeviceBuffer<std::uint32_t> ancestor_;
  BinTable bins_;
  DeviceBuffer<std::uint64_t> bin_key_, bin_weight_, bins_used_;
  DeviceBuffer<std::uint32_t> bin_parent_, bin_slot_, bin_used_;
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
    lines.push_back("cuda " + std::to_string(d) + ": " + std::string(p.name) + ", compute capability " +
                    std::to_string(p.major) + "." + std::to_string(p.minor) + ", " +
                    std::to_string(p.totalGlobalMem >> 20) + " MiB");
  }
  if (lines.empty()) lines.push_back("cuda: built, but no device answers (no GPU, or no driver)");
  return lines;
}

std::unique_ptr<Backend> make_cuda_backend(const BackendConfig& config) {
  if (cuda_device_count() == 0)
    throw Error(ErrorKind::backend,
                "backend cuda: no CUDA device answers (no GPU, or no driver); use --backend cpu");
  if (config.device >= cuda_device_count())
    throw Error(ErrorKind::backend, "backend cuda: there is no device " + std::to_string(config.device) +
                                        "; parloc devices lists " + std::to_string(cuda_device_count()));
  cudaDeviceProp p{};
  PARLOC_CHECK(cudaGetDeviceProperties(&p, config.device), "reading the device's properties");
  return std::make_unique<cuda::CudaBackend>(config, p.name);
}
#endif

}  // namespace parloc
