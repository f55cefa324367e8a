#include "common/slam/slam_backend.h"

#include <algorithm>

#include "common/filter/bind.h"
#include "cuda/device.h"
#include "cuda/poses.h"
#include "cuda/slam_stages.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

/// The tiles that there must be room for are known in the middle of a step only, so a step waits for the
/// device there.
class CudaSlamBackend final : public SlamBackend {
 public:
  CudaSlamBackend(const SlamBackendConfig& config, std::string device_name)
      : config_(config),
        device_(selected(config.device)),  // before anything is allocated
        device_name_(std::move(device_name)),
        count_(static_cast<std::size_t>(config.slam.particles)),
        a_(count_),
        b_(count_) {
    stream_ = make_stream();
    scratch_.reserve(count_);
    for (auto* b : {&log_weight_, &likelihood_, &other_likelihood_}) b->reserve(count_);
    for (auto* b : {&weight_, &cumulative_}) b->reserve(count_);
    ancestor_.reserve(count_);
    state_.reserve(1), freed_.reserve(1);
    resample_.threshold = config.slam.resample_threshold;
    propose_ = bind_propose_rules(config.slam);
    draw_ = bind_draw_rules(config.slam);
    start();
  }
  ~CudaSlamBackend() override {
    store_.reset();
    free_stream(stream_);
  }

  std::string name() const override { return "cuda (" + device_name_ + ")"; }

  void start() override {
    select_device(device_);
    now_ = &a_, other_ = &b_;
    const std::vector<float> zeros(count_, 0.0f);
    for (auto* b : {&a_.x, &a_.y, &a_.theta, &log_weight_, &likelihood_}) b->from_host(zeros, stream_);
    const std::vector<std::uint32_t> count = {static_cast<std::uint32_t>(count_)};
    for (Poses* poses : {&a_, &b_}) poses->live.from_host(count, stream_);
    const std::vector<StepState> states(1);
    state_.from_host(states, stream_);
    const std::vector<std::uint64_t> none(1, 0);
    freed_.from_host(none, stream_);
    store_ = std::make_unique<TileStore>(stream_);
    synchronise(stream_);
    span_ = {};
    last_ = {};
    last_.x = last_.y = last_.theta = last_.likelihood = zeros;
    last_.ancestor.assign(count_, 0);
    taken_ = 1;  // the empty tile
    empty_ = true;
  }

  void move(const MotionStep& motion, RandomKey key, const BeamTable& scan) override {
    select_device(device_);
    set_input(motion, key, scan);
    cover();
    propose(propose_, beams(), maps(), view(*now_), likelihood_.data(), stream_);
    resample_particles();
    cover();
  }
  std::size_t mark() override {
    select_device(device_);
    mark_tiles(draw_, propose_.match, beams(), span_, view(*now_), touched_.data(), stream_);
    count_new_tiles(touched_.data(), count_, maps(), store_->refs(), room_, scratch_, stream_);
    copy_up(&needed_, room_.need.data() + count_ * span_.size() - 1, sizeof needed_, stream_);
    note_size(freed_.to_host(1, stream_)[0]);  // waits for `needed_` as well
    return last_.tiles + static_cast<std::size_t>(needed_);
  }
  const SlamStep& write() override {
    select_device(device_);
    store_->make_room(last_.tiles + needed_, stream_);
    assign_tiles(needed_, count_, maps(), *store_, freed_.data(), room_, scratch_, stream_);
    register_scan(draw_, propose_.match, beams(), maps(), view(*now_), touched_.data(), stream_);
    taken_ += needed_;
    note_size(freed_.to_host(1, stream_)[0]);
    empty_ = empty_ && beams().hits == 0;
    return last_;
  }

  SlamCells map_of(std::size_t particle) const override {
    select_device(device_);
    std::vector<std::uint32_t> table(span_.size());
    copy_up(table.data(), table_.data() + particle * span_.size(), table.size() * sizeof(std::uint32_t),
            stream_);
    synchronise(stream_);
    return gather_cells(span_, table.data(),
                        [&](const std::vector<std::uint32_t>& ids, Tile* to) { read_tiles(ids, to); });
  }

  SlamSnapshot save() const override {
    select_device(device_);
    const std::vector<float> log_weight = log_weight_.to_host(count_, stream_);
    return {last_.x,          last_.y, last_.theta, log_weight,
            last_.likelihood, empty_,  span_,       table_.to_host(count_ * span_.size(), stream_)};
  }

  const SlamStep& load(const SlamSnapshot& s) override {
    select_device(device_);
    now_->x.from_host(s.x, stream_), now_->y.from_host(s.y, stream_), now_->theta.from_host(s.theta, stream_);
    log_weight_.from_host(s.log_weight, stream_);
    likelihood_.from_host(s.likelihood, stream_);
    const std::vector<std::uint32_t> references = count_references(s.table, store_->capacity());
    copy_down(store_->refs(), references.data(), references.size() * sizeof(std::uint32_t), stream_);
    const std::vector<std::uint64_t> none(1, 0);
    freed_.from_host(none, stream_);
    set_tables(s.table);  // waits for all of this
    span_ = s.span;
    empty_ = s.empty;
    taken_ = static_cast<std::uint64_t>(
        std::count_if(references.begin(), references.end(), [](std::uint32_t r) { return r > 0; }));
    last_.x = s.x, last_.y = s.y, last_.theta = s.theta, last_.likelihood = s.likelihood;
    note_size(0);
    return last_;
  }

  std::vector<std::uint32_t> free_tiles(std::size_t count) override {
    select_device(device_);
    const std::vector<std::uint64_t> freed = freed_.to_host(1, stream_);
    store_->make_room(taken_ - freed[0] + count, stream_);
    std::vector<std::uint32_t> references(store_->capacity());
    copy_up(references.data(), store_->refs(), references.size() * sizeof(std::uint32_t), stream_);
    synchronise(stream_);
    return first_free(references.data(), count);
  }
  void write_tiles(const std::vector<std::uint32_t>& ids, const Tile* from) override {
    select_device(device_);
    store_->write(ids, from, stream_);
  }
  void read_tiles(const std::vector<std::uint32_t>& ids, Tile* to) const override {
    select_device(device_);
    store_->read(ids, to, stream_);
  }

 private:
  Particles view(const Poses& p) const {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), p.live.data(), count_};
  }
  SlamMaps maps() const { return {span_, table_.data(), store_->pool()}; }
  Beams beams() { return input_.beams(); }

  void set_input(const MotionStep& motion, RandomKey key, const BeamTable& scan) {
    input_.set_scan(scan);
    input_.host().key = key;
    input_.host().scan_worth = 0.0f;  // no running means of likelihoods
    input_.copy_to_device(stream_);
    propose_.motion = motion;
    propose_.key = key;
    bind_scan(propose_, scan, empty_);
  }
  void resample_particles() {
    const Weights weights{weight_.data(), cumulative_.data()};
    normalise_scan(
        bind_normalise(view(*now_), weights, resample_, state_.data(), {}, &input_.device()->scan_worth),
        scratch_, stream_);
    resample({view(*now_),
              view(*other_),
              weights,
              resample_.scheme,
              {},
              state_.data(),
              ancestor_.data(),
              nullptr,
              nullptr,
              {}},
             input_.device(), scratch_, stream_);
    std::swap(now_, other_);
    last_.x = now_->x.to_host(count_, stream_);
    last_.y = now_->y.to_host(count_, stream_);
    last_.theta = now_->theta.to_host(count_, stream_);
    last_.ancestor = ancestor_.to_host(count_, stream_);
    last_.likelihood = likelihood_.to_host(count_, stream_);
    last_.state = state_.to_host(1, stream_)[0];
    if (last_.state.resample == 0) return;
    inherit_tiles(ancestor_.data(), count_, maps(), other_table_.data(), store_->refs(), freed_.data(),
                  stream_);
    table_.swap(other_table_);
    inherit(last_.likelihood, last_.ancestor);
    likelihood_.from_host(last_.likelihood, stream_);
  }
  /// Tables that hold all that a scan at the poses of last_ can reach.
  void cover() {
    const TileSpan span =
        grown_span(span_, last_.x, last_.y, config_.slam.usable_range, config_.slam.resolution);
    if (span.size() == span_.size()) return;
    const bool none = span_.size() == 0;
    const std::vector<std::uint32_t> old =
        none ? std::vector<std::uint32_t>{} : table_.to_host(count_ * span_.size(), stream_);
    set_tables(moved_tables(old, span_, span, count_));
    span_ = span;
  }
  void set_tables(const std::vector<std::uint32_t>& tables) {
    table_.from_host(tables, stream_);
    synchronise(stream_);
    other_table_.reserve(tables.size());
    touched_.reserve(tables.size());
    room_.need.reserve(tables.size());
    scratch_.reserve(tables.size());
  }
  void note_size(std::uint64_t freed) {
    last_.tiles = taken_ - freed;
    last_.table_bytes = 2 * count_ * span_.size() * sizeof(std::uint32_t);
  }

  SlamBackendConfig config_;
  int device_;
  std::string device_name_;
  std::size_t count_;
  Stream stream_{};
  Scratch scratch_;
  ResampleConfig resample_;
  ProposeRules propose_;
  DrawRules draw_;
  StepInputBuffer input_;
  Poses a_, b_;
  Poses *now_ = &a_, *other_ = &b_;
  DeviceBuffer<float> log_weight_, likelihood_, other_likelihood_;
  DeviceBuffer<std::uint64_t> weight_, cumulative_, freed_;
  DeviceBuffer<std::uint32_t> ancestor_;
  DeviceBuffer<StepState> state_;
  std::unique_ptr<TileStore> store_;
  TileSpan span_;
  DeviceBuffer<std::uint32_t> table_, other_table_;
  DeviceBuffer<std::uint8_t> touched_;
  AssignRoom room_;
  std::uint64_t needed_ = 0;  ///< Tiles, by the last mark().
  std::uint64_t taken_ = 1;   ///< Tiles that were ever taken into use; freed_ counts those given back.
  SlamStep last_;
  bool empty_ = true;  ///< No map has a cell yet.
};

}  // namespace

#if !defined(__CUDACC__)
std::unique_ptr<SlamBackend> make_slam_backend_on_host(const SlamBackendConfig& config) {
  return std::make_unique<CudaSlamBackend>(config, "kernels on the host");
}
#endif
}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
std::unique_ptr<SlamBackend> make_cuda_slam_backend(const SlamBackendConfig& config) {
  return std::make_unique<cuda::CudaSlamBackend>(config, cuda::usable_device(config.device));
}
#endif

}  // namespace parloc
