// The backend of grid SLAM over any memory space; what a space gives, says
// common/filter/engine/filter_engine.h.
#pragma once

#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/filter/engine/step_input_buffer.h"
#include "common/filter/engine/weighted_cloud.h"
#include "common/slam/engine/slam_report.h"
#include "common/slam/slam_backend.h"

namespace parloc {

/// The stages of a scan start together, and whether there is room to write it they find out for themselves:
/// the host waits once. Where there was none, or the tables did not reach so far, it makes room and starts
/// those again that write.
template <class Space>
class SlamEngine final : public SlamBackend {
 public:
  explicit SlamEngine(const SlamBackendConfig& config)
      : config_(config),
        queue_(Space::Queue::open(config.threads, config.device)),  // before anything is allocated
        count_(static_cast<std::size_t>(config.slam.particles)),
        resample_{.threshold = config.slam.resample_threshold},
        cloud_(count_, resample_),
        report_(count_) {
    queue_.reserve(count_);
    state_.reserve(1);
    for (auto& l : likelihood_) l.reserve(count_);
    kept_.reserve(5 * count_);
    rules_ = bind_propose_rules(config.slam);
    draw_ = bind_draw_rules(config.slam);
    start();
  }

  std::string name() const override { return queue_.name(); }

  void start() override {
    queue_.use();
    typename Space::TileStore store(
        queue_);  // beside the old one, which stays if there is no memory for this
    recordings_.forget();
    const std::vector<float> zeros(count_, 0.0f);
    cloud_.upload({zeros, zeros, zeros, zeros}, queue_);
    likelihood().from_host(zeros, queue_);
    *state_.host() = {};
    state_.send(queue_);
    new_tiles_.clear(queue_);
    store_ = std::move(store);
    queue_.wait();
    span_ = {};
    last_ = {};
    last_.x = last_.y = last_.theta = last_.likelihood = zeros;
    last_.ancestor.assign(count_, 0);
    before_ = last_;
    empty_ = true;
  }

  void move(const MotionStep& motion, RandomKey key, const BeamTable& scan, std::size_t most_tiles) override {
    queue_.use();
    cover();
    set_input(motion, key, scan, most_tiles);
    recordings_.run(cloud_.turn() + 2 * table_turn_, queue_, [this] { start_scan(); });
    queue_.wait();
    const SlamReportHead& head = *report_.host().head;
    const SlamSnapshot unmoved = head.tally.fits != 0 ? SlamSnapshot{} : kept();
    cloud_.take_turns();
    if (head.state.resample != 0) table_turn_ ^= 1u;
    std::swap(last_, before_);
    note();
    if (!written_) move_on(unmoved, most_tiles);
    if (written_) finish();
  }
  std::size_t mark() override {
    queue_.use();
    if (!marked_) {
      Space::mark_tiles(args(), queue_);
      Space::find_new_tiles(args(), *store_, new_tiles_, queue_);
      bring_report();
      marked_ = true;
    }
    const SlamTally& tally = report_.host().head->tally;
    return static_cast<std::size_t>(tally.used + tally.needed);
  }
  const SlamStep& write() override {
    queue_.use();
    if (written_) return last_;
    input_.host().most_tiles = kNoTileLimit;
    write_with_room();
    finish();
    return last_;
  }

  SlamCells map_of(std::size_t particle) const override {
    queue_.use();
    const std::vector<std::uint32_t> table = tables().to_host(span_.size(), queue_, particle * span_.size());
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
            tables().to_host(places(), queue_)};
  }

  const SlamStep& load(const SlamSnapshot& s) override {
    queue_.use();
    reserve_tables(s.table.size());
    cloud_.upload({s.x, s.y, s.theta, s.log_weight}, queue_);
    likelihood().from_host(s.likelihood, queue_);
    tables().from_host(s.table, queue_);
    recordings_.forget();  // they know the old span
    store_->set_references(count_references(s.table, store_->capacity()), queue_);
    span_ = s.span;
    empty_ = s.empty;
    last_.x = s.x, last_.y = s.y, last_.theta = s.theta, last_.likelihood = s.likelihood;
    last_.tiles = store_->used(queue_);
    note_table_bytes();
    marked_ = written_ = false;
    return last_;
  }

  std::vector<std::uint32_t> free_tiles(std::size_t count) override {
    queue_.use();
    make_room(store_->used(queue_) + count);
    return store_->first_free(count, queue_);
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
  template <class T>
  using Array = typename Space::template Array<T>;

  /// Of all tables.
  std::size_t places() const { return count_ * span_.size(); }
  Array<std::uint32_t>& tables() { return table_[table_turn_]; }
  const Array<std::uint32_t>& tables() const { return table_[table_turn_]; }
  Array<float>& likelihood() { return likelihood_[cloud_.turn()]; }

  KeptParticles kept_particles() {
    float* const k = kept_.data();
    return {k, k + count_, k + 2 * count_, k + 3 * count_, k + 4 * count_};
  }
  /// Particles and tables as they are.
  SlamArgs args() {
    return {.rules = rules_,
            .draw = draw_,
            .beams = input_.beams(),
            .most_beams = input_.capacity(),
            .input = input_.input(),
            .maps = {span_, tables().data(), store_->pool()},
            .state = state_.there(),
            .particles = cloud_.now(),
            .ancestor = cloud_.ancestor(),
            .likelihood = likelihood().data(),
            .other_likelihood = likelihood_[cloud_.turn() ^ 1u].data(),
            .kept = kept_particles(),
            .reach_m = config_.slam.usable_range,
            .tile_m = kTileCells * config_.slam.resolution,
            .touched = touched_.data(),
            .tally = new_tiles_.tally()};
  }
  void set_input(const MotionStep& motion, RandomKey key, const BeamTable& scan, std::size_t most_tiles) {
    if (!input_.has_room_for(scan)) recordings_.forget();  // they know the arrays' old place
    input_.set_scan(scan);
    rules_.motion = motion;
    bind_scan(rules_, scan, empty_);
    SlamInput& input = input_.host();
    input.key = key;
    input.scan_worth = 0.0f;  // no running means of likelihoods
    input.motion = rules_.motion;
    input.matched = rules_.beams;
    input.most_tiles = most_tiles;
  }

  /// Everything that differs from the last scan is in input_, so this may be recorded.
  void start_scan() {
    input_.send(queue_);
    Space::propose(args(), queue_);
    cloud_.normalise(input_.input(), state_.there(), {}, false, queue_);
    cloud_.resample(input_.input(), state_.there(), {}, queue_);
    SlamArgs a = args();
    a.other_table = table_[table_turn_ ^ 1u].data();
    Space::inherit_tiles(a, *store_, queue_);
    a.particles = cloud_.other();
    a.likelihood = a.other_likelihood;
    start_writing(a);
  }
  void start_writing(const SlamArgs& a) {
    Space::mark_tiles(a, queue_);
    Space::find_new_tiles(a, *store_, new_tiles_, queue_);
    Space::assign_tiles(a, *store_, new_tiles_, queue_);
    Space::register_scan(a, queue_);
    Space::report_scan(a, *store_, report_.there(), queue_);
    report_.fetch(queue_);
  }
  /// Where there may be room now.
  void write_again() {
    input_.send(queue_);
    start_writing(args());
    queue_.wait();
    note();
  }
  void write_with_room() {
    make_room(mark());
    write_again();
  }
  /// After a scan that did not fit. Throws what there is no room for, and then nothing has changed.
  void move_on(const SlamSnapshot& unmoved, std::size_t most_tiles) {
    try {
      if (cover()) write_again();
      if (!written_ && mark() <= most_tiles) write_with_room();
    } catch (...) {
      load(unmoved);
      std::swap(last_, before_);
      throw;
    }
  }
  /// Before take_turns(): as it was before the particles were moved.
  SlamSnapshot kept() {
    const std::vector<float> k = kept_.to_host(5 * count_, queue_);
    const auto part = [&](std::size_t p) {
      const auto from = k.begin() + static_cast<std::ptrdiff_t>(p * count_);
      return std::vector<float>(from, from + static_cast<std::ptrdiff_t>(count_));
    };
    return {part(0), part(1), part(2), part(3), part(4), empty_, span_, tables().to_host(places(), queue_)};
  }

  void bring_report() {
    Space::report_scan(args(), *store_, report_.there(), queue_);
    report_.fetch(queue_);
    queue_.wait();
  }
  /// What came of a scan, into last_.
  void note() {
    const SlamReport r = report_.host();
    const auto copy = [this](const auto* from, auto& to) { to.assign(from, from + count_); };
    copy(r.x, last_.x), copy(r.y, last_.y), copy(r.theta, last_.theta);
    copy(r.likelihood, last_.likelihood);
    copy(r.ancestor, last_.ancestor);
    last_.state = r.head->state;
    last_.tiles = static_cast<std::size_t>(r.head->tiles);
    note_table_bytes();
    marked_ = true;
    written_ = r.head->tally.fits != 0;
  }
  void note_table_bytes() { last_.table_bytes = 2 * places() * sizeof(std::uint32_t); }
  /// Of a scan that was written: memory for the next ones.
  void finish() {
    empty_ = empty_ && input_.host().scan.hits == 0;
    const auto taken = static_cast<std::size_t>(report_.host().head->tally.needed);
    if (last_.tiles + 2 * taken <= store_->capacity()) return;
    try {
      make_room(last_.tiles + last_.tiles / 2 + 2 * taken);
    } catch (const std::exception&) {  // then the scan that needs it says so
    }
  }
  void make_room(std::size_t tiles) {
    if (tiles <= store_->capacity()) return;
    recordings_.forget();  // they know the old place
    store_->make_room(tiles, queue_);
  }

  /// Tables that hold all that a scan at the poses of last_ can reach; whether they have changed for it.
  bool cover() {
    const TileSpan span =
        grown_span(span_, last_.x, last_.y, config_.slam.usable_range, config_.slam.resolution);
    if (span.size() == span_.size()) return false;
    const std::vector<std::uint32_t> moved =
        moved_tables(tables().to_host(places(), queue_), span_, span, count_);
    reserve_tables(moved.size());
    tables().from_host(moved, queue_);
    recordings_.forget();  // they know the old span
    span_ = span;
    note_table_bytes();
    marked_ = false;
    return true;
  }
  /// What the current tables hold is kept if it throws, and else lost.
  void reserve_tables(std::size_t size) {
    if (size <= touched_.size()) return;
    recordings_.forget();
    Array<std::uint32_t> one, other;
    one.reserve(size), other.reserve(size);
    new_tiles_.reserve(size);
    queue_.reserve(size);
    touched_.reserve(size);
    table_[0].swap(one), table_[1].swap(other);
  }

  SlamBackendConfig config_;
  typename Space::Queue queue_;
  typename Space::Recordings recordings_;
  std::size_t count_;
  ResampleConfig resample_;
  ProposeRules rules_;
  DrawRules draw_;
  StepInputBuffer<Space, SlamInput> input_;
  WeightedCloud<Space> cloud_;
  Array<float> likelihood_[2];  // take turns with the cloud
  Array<float> kept_;
  typename Space::template Mirror<StepState> state_;
  SlamReportBuffer<Space> report_;
  std::optional<typename Space::TileStore> store_;
  TileSpan span_;
  Array<std::uint32_t> table_[2];
  unsigned table_turn_ = 0;  // the one in use
  Array<std::uint8_t> touched_;
  typename Space::NewTiles new_tiles_;
  SlamStep last_, before_;  // and of the scan before
  bool marked_ = false;     // the report's tally is that of now
  bool written_ = false;    // the scan of the last move()
  bool empty_ = true;       // no map has a cell yet
};

}  // namespace parloc
