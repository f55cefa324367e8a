#include "common/search/global_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/math/portable64.h"
#include "common/model/beams.h"
#include "common/search/hypotheses.h"
#include "common/search/judge_places.h"
#include "common/search/lattice_search.h"
#include "common/search/search_backend.h"
#include "common/search/search_parts.h"
#include "common/search/search_task.h"

namespace parloc {
namespace {

constexpr std::int64_t kWhole = std::numeric_limits<std::int64_t>::max();

void expect(bool good, const char* setting, const char* limits) {
  if (!good) throw Error(ErrorKind::config, std::string("search.") + setting + ": expected " + limits);
}

std::unique_ptr<SearchBackend> choose_backend(const SearchMap& map, const ComputeConfig& c,
                                              std::string& why) {
  if (takes_cuda(c.backend, why)) {
    if constexpr (PARLOC_WITH_CUDA != 0) return make_cuda_search(map, c.device);
  }
  return make_cpu_search(map, c.threads);
}

}  // namespace

void validate(const SearchConfig& c) {
  expect(c.cell_m > 0.0 && c.cell_m <= 10.0, "cell_m", "a number above 0, at most 10");
  expect(c.sigma_m > 0.0 && c.sigma_m <= 10.0, "sigma_m", "a number above 0, at most 10");
  expect(c.beams >= 1 && c.beams <= 256, "beams", "a whole number from 1 to 256");
  expect(c.heading_cells > 0.0 && c.heading_cells <= 100.0, "heading_cells", "a number above 0, at most 100");
  expect(c.max_headings >= 72 && c.max_headings <= 10000, "max_headings", "a whole number from 72 to 10000");
  expect(c.least_score >= 0.0 && c.least_score <= 1.0, "least_score", "a number from 0 to 1");
  expect(c.least_share >= 0.0 && c.least_share <= 1.0, "least_share", "a number from 0 to 1");
  expect(c.separation_m >= 0.0 && std::isfinite(c.separation_m), "separation_m", "a number from 0 up");
  expect(c.separation_rad >= 0.0 && c.separation_rad <= kPi, "separation_rad", "a number from 0 to pi");
  expect(c.candidates >= 1 && c.candidates <= 10000, "candidates", "a whole number from 1 to 10000");
  expect(c.most >= 1 && c.most <= c.candidates, "most", "a whole number from 1 to candidates");
  expect(c.effective_beams > 0.0 && c.effective_beams <= 4096.0, "effective_beams",
         "a number above 0, at most 4096");
  expect(c.ambiguous_share >= 0.0 && c.ambiguous_share <= 1.0, "ambiguous_share", "a number from 0 to 1");
}

struct GlobalSearch::State {
  State(const GridMap& grid, const SearchConfig& c, const ComputeConfig& compute,
        std::shared_ptr<const SearchMap> ready)
      : config(c),
        T_map_grid(grid.T_map_grid),
        name(grid.name),
        resolution_m(grid.resolution_m),
        shared(std::move(ready)),
        map(*shared),
        judge(grid, map, c),
        backend(choose_backend(map, compute, why)) {
    if (map.free_count == 0) throw Error(ErrorKind::input, name + ": the map has no free cell");
  }

  void begin(const BeamTable& table, const SearchPrior& prior, std::size_t most);
  void begin_judging();
  std::int64_t step(std::int64_t work);
  std::int64_t turn(std::int64_t work);

  SearchConfig config;
  Pose T_map_grid;
  std::string name;
  double resolution_m;
  std::shared_ptr<const SearchMap> shared;
  const SearchMap& map;
  JudgePlaces judge;
  std::string why;
  std::unique_ptr<SearchBackend> backend;

  enum class Stage { idle, turn, lattice, separate, judge, done };
  Stage stage = Stage::idle;
  bool lattice_only = false;
  std::int64_t work_done = 0;
  SearchTask task;
  SearchScan scan;
  std::int32_t turned = 0;  // headings of the task
  LatticeSearch lattice;
  SeparatePoses places;
  BeamTable beams, selected;  // of the search; of a scan that is not selected yet
};

void GlobalSearch::State::begin(const BeamTable& table, const SearchPrior& prior, std::size_t most) {
  stage = Stage::idle;
  work_done = 0;
  choose_search_beams(table, resolution_m, map.cell_m, config, scan);
  task = make_search_task(map, T_map_grid, name, config, scan, prior);
  beams = table;
  turned = 0;
  places.begin(map.shape, scan.headings, map.cell_m, {config.separation_m, config.separation_rad}, most);
  stage = scan.beams > 0 ? Stage::turn : Stage::separate;  // without a hit there is no place
}

void GlobalSearch::State::begin_judging() {
  judge.begin(beams, places.taken(), scan.headings);
  stage = lattice_only || judge.done() ? Stage::done : Stage::judge;
}

/// Offsets for the headings that are asked for.
std::int64_t GlobalSearch::State::turn(std::int64_t work) {
  const std::int64_t each = search_work::kTurnedBeam * scan.beams;
  std::int64_t spent = 0;
  while (turned < task.heading_count && (spent == 0 || spent < work)) {
    turn_search_scan(scan, map.cell_m, task.heading(turned++));
    spent += each;
  }
  return spent;
}

std::int64_t GlobalSearch::State::step(std::int64_t work) {
  std::int64_t spent = 0;
  switch (stage) {
    case Stage::turn:
      spent = turn(work);
      if (turned < task.heading_count) break;
      lattice.begin(*backend, task, scan, places.keys);
      stage = Stage::lattice;
      break;
    case Stage::lattice:
      spent = lattice.advance(work);
      if (lattice.done()) stage = Stage::separate;
      break;
    case Stage::separate:
      spent = places.advance(work);
      if (places.done()) begin_judging();
      break;
    case Stage::judge:
      spent = judge.advance(work);
      if (judge.done()) stage = Stage::done;
      break;
    case Stage::idle:
    case Stage::done:
      break;
  }
  return spent;
}

GlobalSearch::GlobalSearch(const GridMap& map, const SearchConfig& config, const ComputeConfig& compute)
    : GlobalSearch(map, config, compute, nullptr) {}
GlobalSearch::GlobalSearch(const GridMap& map, const SearchConfig& config, const ComputeConfig& compute,
                           const GlobalSearch* beside) {
  validate(config);
  validate(map);
  if (compute.threads < 0 || compute.threads > 4096)
    throw Error(ErrorKind::config, "threads: expected a whole number from 0 to 4096");
  state_ = std::make_unique<State>(map, config, compute,
                                   beside != nullptr
                                       ? beside->state_->shared
                                       : std::make_shared<const SearchMap>(make_search_map(map, config)));
}
GlobalSearch::~GlobalSearch() = default;
GlobalSearch::GlobalSearch(GlobalSearch&&) noexcept = default;
GlobalSearch& GlobalSearch::operator=(GlobalSearch&&) noexcept = default;

void GlobalSearch::begin(const BeamTable& beams, const SearchPrior& prior) {
  state_->lattice_only = false;
  state_->begin(beams, prior, static_cast<std::size_t>(state_->config.candidates));
}

bool GlobalSearch::advance(std::int64_t work) {
  State& s = *state_;
  std::int64_t spent = 0;
  do {
    spent += s.step(work - spent);
  } while (under_way() && spent < work);
  s.work_done += spent;
  return !under_way();
}

bool GlobalSearch::under_way() const {
  return state_->stage != State::Stage::idle && state_->stage != State::Stage::done;
}

void GlobalSearch::forget() {
  cancel();
  state_->judge.forget();
}
void GlobalSearch::learn(double range_max_m) {
  state_->judge.learn(static_cast<float>(range_max_m));
}
void GlobalSearch::cancel() {
  if (under_way()) state_->stage = State::Stage::idle;
}

std::int64_t GlobalSearch::work_done() const {
  return state_->work_done;
}

SearchResult GlobalSearch::result() const {
  const State& s = *state_;
  if (s.stage != State::Stage::done || s.lattice_only)
    throw Error(ErrorKind::internal, "GlobalSearch::result: no search is finished");
  SearchResult result;
  result.beams = static_cast<std::size_t>(s.scan.beams);
  result.headings = static_cast<std::size_t>(s.scan.headings);
  s.judge.report(result);
  return result;
}

std::vector<LatticePose> SearchParts::search_lattice(const BeamTable& beams, const SearchPrior& prior,
                                                     std::size_t most) {
  GlobalSearch::State& s = *search_.state_;
  s.lattice_only = true;
  s.begin(beams, prior, most);
  while (!search_.advance(kWhole)) {
  }
  return s.places.taken();
}

SearchResult GlobalSearch::search(const BeamTable& beams, const SearchPrior& prior) {
  begin(beams, prior);
  while (!advance(kWhole)) {
  }
  return result();
}

SearchResult GlobalSearch::search(const Scan& scan, const StepConfig& config, const SearchPrior& prior) {
  State& s = *state_;
  BeamCounts counts;
  const LidarSetup setup = lidar_setup(scan, config.scan, find_lidar(config.lidars, scan.sensor));
  select_beams(scan, setup, nullptr, default_sensor(SensorModel::beam), s.resolution_m, s.selected, counts);
  return search(s.selected, prior);
}

const SearchMap& SearchParts::map() const {
  return search_.state_->map;
}
const SearchScan& SearchParts::scan() const {
  return search_.state_->scan;
}
std::string GlobalSearch::backend_name() const {
  return state_->backend->name();
}
const std::string& GlobalSearch::backend_reason() const {
  return state_->why;
}

}  // namespace parloc
