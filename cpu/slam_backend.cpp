#include "common/slam/slam_backend.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <utility>

#include "common/filter/bind.h"
#include "cpu/poses.h"
#include "cpu/slam_stages.h"
#include "cpu/stages.h"

namespace parloc {
namespace {

class CpuSlamBackend final : public SlamBackend {
 public:
  explicit CpuSlamBackend(const SlamBackendConfig& config)
      : config_(config),
        count_(static_cast<std::size_t>(config.slam.particles)),
        now_(count_),
        other_(count_),
        log_weight_(count_),
        weight_(count_),
        cumulative_(count_) {
    workers_.threads = config.threads > 0 ? config.threads : omp_get_num_procs();
    workers_.reserve(count_);
    resample_.threshold = config.slam.resample_threshold;
    propose_ = bind_propose_rules(config.slam);
    draw_ = bind_draw_rules(config.slam);
    start();
  }

  std::string name() const override {
    return fmt::format("cpu ({}, {} thread{})", cpu::simd_name(cpu::simd_level()), workers_.threads,
                       workers_.threads == 1 ? "" : "s");
  }

  void start() override {
    now_ = cpu::Poses(count_);
    std::fill(log_weight_.begin(), log_weight_.end(), 0.0f);
    store_ = cpu::TileStore();
    span_ = {};
    table_.clear(), other_table_.clear();
    last_ = {};
    last_.likelihood.assign(count_, 0.0f);
    last_.ancestor.assign(count_, 0);
    empty_ = true;
  }

  void move(const MotionStep& motion, RandomKey key, const BeamTable& scan) override {
    scan_ = &scan;
    propose(motion, key, scan);
    resample(key);
    cover(now_);
    note_state();
  }
  std::size_t mark() override {
    cpu::mark_tiles(draw_, propose_.match, bind_beams(*scan_), span_, view(now_), touched_.data(), workers_);
    cpu::list_new_tiles(touched_.data(), count_, maps(), store_, fresh_);
    return store_.used() + fresh_.size();
  }
  const SlamStep& write() override {
    const Beams beams = bind_beams(*scan_);
    cpu::assign_tiles(fresh_, maps(), store_, workers_);
    cpu::register_scan(draw_, propose_.match, beams, maps(), view(now_), touched_.data(), workers_);
    empty_ = empty_ && beams.hits == 0;
    note_state();
    return last_;
  }

  SlamCells map_of(std::size_t particle) const override {
    return gather_cells(span_, table_.data() + particle * span_.size(),
                        [&](const std::vector<std::uint32_t>& ids, Tile* to) { read_tiles(ids, to); });
  }

  SlamSnapshot save() const override {
    return {now_.x, now_.y, now_.theta, log_weight_, last_.likelihood, empty_, span_, table_};
  }

  const SlamStep& load(const SlamSnapshot& s) override {
    now_.x = s.x, now_.y = s.y, now_.theta = s.theta;
    log_weight_ = s.log_weight;
    last_.likelihood = s.likelihood;
    empty_ = s.empty;
    span_ = s.span;
    set_tables(s.table);
    store_.set_refs(count_references(table_, store_.capacity()));
    note_state();
    return last_;
  }

  std::vector<std::uint32_t> free_tiles(std::size_t count) override {
    store_.make_room(count);
    return first_free(store_.refs(), count);
  }
  void write_tiles(const std::vector<std::uint32_t>& ids, const Tile* from) override {
    for (const std::uint32_t id : ids) store_.pool().at(id) = *from++;
  }
  void read_tiles(const std::vector<std::uint32_t>& ids, Tile* to) const override {
    for (const std::uint32_t id : ids) *to++ = store_.pool().at(id);
  }

 private:
  Particles view(cpu::Poses& p) {
    return {p.x.data(), p.y.data(), p.theta.data(), log_weight_.data(), &p.count, p.x.size()};
  }
  SlamMaps maps() { return {span_, table_.data(), store_.pool()}; }

  void propose(const MotionStep& motion, RandomKey key, const BeamTable& scan) {
    cover(now_);
    propose_.motion = motion;
    propose_.key = key;
    bind_scan(propose_, scan, empty_);
    cpu::propose(propose_, bind_beams(scan), maps(), view(now_), last_.likelihood.data(), workers_);
  }
  void resample(RandomKey key) {
    const Weights weights{weight_.data(), cumulative_.data()};
    const float no_means = 0.0f;
    cpu::normalise_scan(bind_normalise(view(now_), weights, resample_, &last_.state, {}, &no_means),
                        workers_);
    cpu::resample({view(now_),
                   view(other_),
                   weights,
                   resample_.scheme,
                   key,
                   &last_.state,
                   last_.ancestor.data(),
                   nullptr,
                   nullptr,
                   {}},
                  workers_);
    std::swap(now_, other_);
    if (last_.state.resample == 0) return;
    cpu::inherit_tiles(last_.ancestor.data(), count_, maps(), other_table_.data(), store_, workers_);
    std::swap(table_, other_table_);
    inherit(last_.likelihood, last_.ancestor);
  }
  /// Tables that hold all that a scan at these poses can reach.
  void cover(const cpu::Poses& poses) {
    const TileSpan span =
        grown_span(span_, poses.x, poses.y, config_.slam.usable_range, config_.slam.resolution);
    if (span.size() == span_.size()) return;
    set_tables(moved_tables(table_, span_, span, count_));
    span_ = span;
  }
  void set_tables(std::vector<std::uint32_t> tables) {
    table_ = std::move(tables);
    other_table_.assign(table_.size(), kNoTile);
    touched_.assign(table_.size(), 0);
  }
  void note_state() {
    last_.x = now_.x, last_.y = now_.y, last_.theta = now_.theta;
    last_.tiles = store_.used();
    last_.table_bytes = (table_.size() + other_table_.size()) * sizeof(std::uint32_t);
  }

  SlamBackendConfig config_;
  std::size_t count_;
  cpu::Workers workers_;
  ResampleConfig resample_;
  ProposeRules propose_;
  DrawRules draw_;
  cpu::Poses now_, other_;
  std::vector<float> log_weight_;
  std::vector<std::uint64_t> weight_, cumulative_;
  cpu::TileStore store_;
  TileSpan span_;
  std::vector<std::uint32_t> table_, other_table_;
  std::vector<std::uint8_t> touched_;
  std::vector<cpu::NewTile> fresh_;
  const BeamTable* scan_ = nullptr;  ///< Between move() and write().
  SlamStep last_;
  bool empty_ = true;  ///< No map has a cell yet.
};

}  // namespace

std::unique_ptr<SlamBackend> make_cpu_slam_backend(const SlamBackendConfig& config) {
  return std::make_unique<CpuSlamBackend>(config);
}

}  // namespace parloc
