// The backend of grid SLAM over any memory space; what a space gives, says
// common/filter/engine/filter_engine.h.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/filter/engine/step_input_buffer.h"
#include "common/filter/engine/weighted_cloud.h"
#include "common/slam/slam_backend.h"

namespace parloc {

/// The tiles that there must be room for are known in the middle of a step only, so a step waits for its
/// stages there.
template <class Space>
class SlamEngine final : public SlamBackend {
 public:
  explicit SlamEngine(const SlamBackendConfig& config)
      : config_(config),
        queue_(Space::Queue::open(config.threads, config.device)),  // before anything is allocated
        count_(static_cast<std::size_t>(config.slam.particles)),
        resample_{.threshold = config.slam.resample_threshold},
        cloud_(count_, resample_) {
    queue_.reserve(count_);
    state_.reserve(1);
    rules_ = bind_propose_rules(config.slam);
    draw_ = bind_draw_rules(config.slam);
    start();
  }

  std::string name() const override { return queue_.name(); }

  void start() override {
    queue_.use();
    const std::vector<float> zeros(count_, 0.0f);
    cloud_.upload({zeros, zeros, zeros, zeros}, queue_);
    likelihood_.from_host(zeros, queue_);
    *state_.host() = {};
    state_.send(queue_);
    store_.emplace(queue_);
    queue_.wait();
    span_ = {};
    last_ = {};
    last_.x = last_.y = last_.theta = last_.likelihood = zeros;
    last_.ancestor.assign(count_, 0);
    empty_ = true;
  }

  void move(const MotionStep& motion, RandomKey key, const BeamTable& scan) override {
    queue_.use();
    input_.set_scan(scan);
    input_.host().key = key;
    input_.host().scan_worth = 0.0f;  // no running means of likelihoods
    input_.send(queue_);
    rules_.motion = motion;
    rules_.key = key;
    bind_scan(rules_, scan, empty_);
    cover();
    Space::propose(args(), queue_);
    resample();
    cover();
  }
  std::size_t mark() override {
    queue_.use();
    Space::mark_tiles(args(), queue_);
    Space::find_new_tiles(args(), *store_, new_tiles_, queue_);
    note_size();  // waits
    return last_.tiles + new_tiles_.count();
  }
  const SlamStep& write() override {
    queue_.use();
    store_->make_room(last_.tiles + new_tiles_.count(), queue_);
    Space::assign_tiles(args(), *store_, new_tiles_, queue_);
    Space::register_scan(args(), queue_);
    note_size();
    empty_ = empty_ && input_.host().scan.hits == 0;
    return last_;
  }

  SlamCells map_of(std::size_t particle) const override {
    queue_.use();
    const std::vector<std::uint32_t> table = table_.to_host(span_.size(), queue_, particle * span_.size());
    return gather_cells(span_, table.data(),
                        [&](const std::vector<std::uint32_t>& ids, Tile* to) { read_tiles(ids, to); });
  }

  SlamSnapshot save() const override {
    queue_.use();
    ParticleSet p = cloud_.download(count_, queue_);
    return {std::move(p.x),
            std::move(p.y),
            std::move(p.theta),
            std::move(p.log_weight),
            last_.likelihood,
            empty_,
            span_,
            table_.to_host(places(), queue_)};
  }

  const SlamStep& load(const SlamSnapshot& s) override {
    queue_.use();
    cloud_.upload({s.x, s.y, s.theta, s.log_weight}, queue_);
    likelihood_.from_host(s.likelihood, queue_);
    set_tables(s.table);  // waits
    store_->set_references(count_references(s.table, store_->capacity()), queue_);
    span_ = s.span;
    empty_ = s.empty;
    last_.x = s.x, last_.y = s.y, last_.theta = s.theta, last_.likelihood = s.likelihood;
    note_size();
    return last_;
  }

  std::vector<std::uint32_t> free_tiles(std::size_t count) override {
    queue_.use();
    store_->make_room(store_->used(queue_) + count, queue_);
    return first_free(store_->references(queue_).data(), count);
  }
  void write_tiles(const std::vector<std::uint32_t>& ids, const Tile* from) override {
    queue_.use();
    store_->write(ids, from, queue_);
  }
  void read_tiles(const std::vector<std::uint32_t>& ids, Tile* to) const override {
    queue_.use();
    store_->read(ids, to, queue_);
  }

 private:
  /// Of all tables.
  std::size_t places() const { return count_ * span_.size(); }
  SlamArgs args() {
    return {.rules = rules_,
            .draw = draw_,
            .beams = input_.beams(),
            .maps = {span_, table_.data(), store_->pool()},
            .particles = cloud_.now(),
            .likelihood = likelihood_.data(),
            .touched = touched_.data()};
  }

  void resample() {
    cloud_.normalise(input_.input(), state_.there(), {}, false, queue_);
    cloud_.resample(input_.input(), state_.there(), {}, queue_);
    cloud_.take_turns();
    state_.fetch(queue_);
    ParticleSet p = cloud_.download(count_, queue_);  // waits
    last_.x = std::move(p.x), last_.y = std::move(p.y), last_.theta = std::move(p.theta);
    last_.ancestor = cloud_.ancestors(count_, queue_);
    last_.likelihood = likelihood_.to_host(count_, queue_);
    last_.state = *state_.host();
    if (last_.state.resample == 0) return;
    Space::inherit_tiles(args(), cloud_.ancestor(), other_table_.data(), *store_, queue_);
    table_.swap(other_table_);
    inherit(last_.likelihood, last_.ancestor);
    likelihood_.from_host(last_.likelihood, queue_);
  }
  /// Tables that hold all that a scan at the poses of last_ can reach.
  void cover() {
    const TileSpan span =
        grown_span(span_, last_.x, last_.y, config_.slam.usable_range, config_.slam.resolution);
    if (span.size() == span_.size()) return;
    set_tables(moved_tables(table_.to_host(places(), queue_), span_, span, count_));
    span_ = span;
  }
  void set_tables(std::vector<std::uint32_t> tables) {
    const std::size_t size = tables.size();
    table_.take(std::move(tables), queue_);
    other_table_.reserve(size);
    touched_.reserve(size);
    new_tiles_.reserve(size);
    queue_.reserve(size);
  }
  void note_size() {
    last_.tiles = store_->used(queue_);
    last_.table_bytes = 2 * places() * sizeof(std::uint32_t);
  }

  template <class T>
  using Array = typename Space::template Array<T>;

  SlamBackendConfig config_;
  typename Space::Queue queue_;
  std::size_t count_;
  ResampleConfig resample_;
  ProposeRules rules_;
  DrawRules draw_;
  StepInputBuffer<Space> input_;
  WeightedCloud<Space> cloud_;
  Array<float> likelihood_;
  typename Space::template Mirror<StepState> state_;
  std::optional<typename Space::TileStore> store_;
  TileSpan span_;
  Array<std::uint32_t> table_, other_table_;
  Array<std::uint8_t> touched_;
  typename Space::NewTiles new_tiles_;
  SlamStep last_;
  bool empty_ = true;  ///< No map has a cell yet.
};

}  // namespace parloc
