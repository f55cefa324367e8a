#include "common/search/global_search.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/filter/filter_backend.h"
#include "common/math/portable.h"
#include "common/math/portable64.h"
#include "common/model/beams.h"
#include "common/search/hypotheses.h"
#include "common/search/pose_evidence.h"
#include "common/search/search_backend.h"

namespace parloc {
namespace {

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

std::int32_t block_of(double x_m, double cell_m, std::int32_t blocks) {
  const double block = std::floor(x_m / (cell_m * kBlockCells));
  return static_cast<std::int32_t>(std::clamp(block, 0.0, static_cast<double>(blocks)));
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
  State(const GridMap& grid, const SearchConfig& c, const ComputeConfig& compute)
      : config(c),
        T_map_grid(grid.T_map_grid),
        name(grid.name),
        resolution_m(grid.resolution_m),
        map(make_search_map(grid, c)),
        judge(grid, map),
        backend(choose_backend(map, compute, why)) {
    if (map.free_count == 0) throw Error(ErrorKind::input, name + ": the map has no free cell");
  }

  SearchTask task(const SearchPrior& prior) const;
  void set_region(const SearchPrior::Disc& disc, SearchTask& task) const;
  void set_headings(const SearchPrior::Interval& interval, SearchTask& task) const;
  Separation separation() const { return {config.separation_m, config.separation_rad}; }

  SearchConfig config;
  Pose T_map_grid;
  std::string name;
  double resolution_m;
  SearchMap map;
  PoseEvidence judge;
  std::string why;
  std::unique_ptr<SearchBackend> backend;
  SearchScan scan;
  std::vector<std::uint64_t> champions;
  BeamTable beams;
};

SearchTask GlobalSearch::State::task(const SearchPrior& prior) const {
  SearchTask t;
  t.grid = map.shape;
  t.beams = scan.beams;
  t.headings = t.heading_count = scan.headings;
  t.block_end_i = t.grid.blocks_x();
  t.block_end_j = t.grid.blocks_y();
  if (prior.region) set_region(*prior.region, t);
  if (prior.heading) set_headings(*prior.heading, t);
  const double full = static_cast<double>(kMostValue) * scan.beams;
  t.least = std::max(1u, static_cast<std::uint32_t>(std::floor(config.least_score * full)));
  t.share_1024th = static_cast<std::uint32_t>(std::floor(config.least_share * 1024.0));
  return t;
}

void GlobalSearch::State::set_region(const SearchPrior::Disc& disc, SearchTask& t) const {
  if (!std::isfinite(disc.x_m) || !std::isfinite(disc.y_m) || !(disc.radius_m >= 0.0) ||
      !std::isfinite(disc.radius_m))
    throw Error(ErrorKind::input, "search region: expected a finite place and a radius from 0 up");
  const Pose centre = relative({disc.x_m, disc.y_m, 0.0}, T_map_grid);
  const double half_cells = 2.0 / map.cell_m;
  constexpr double far = 1e8;  // beyond any map
  const auto whole = [](double x) { return static_cast<std::int64_t>(std::floor(x + 0.5)); };
  t.region.x = whole(std::clamp(centre.x_m * half_cells, -far, far));
  t.region.y = whole(std::clamp(centre.y_m * half_cells, -far, far));
  const double radius = std::min(disc.radius_m * half_cells, 4.0 * far);
  t.region.squared_radius = static_cast<std::int64_t>(std::floor(radius * radius));
  const double reach_m = disc.radius_m + map.cell_m;  // the centre was rounded
  t.block_i = block_of(centre.x_m - reach_m, map.cell_m, t.block_end_i);
  t.block_j = block_of(centre.y_m - reach_m, map.cell_m, t.block_end_j);
  t.block_end_i = std::min(t.block_end_i, block_of(centre.x_m + reach_m, map.cell_m, t.block_end_i) + 1);
  t.block_end_j = std::min(t.block_end_j, block_of(centre.y_m + reach_m, map.cell_m, t.block_end_j) + 1);
  const SearchGrid grid = map.view();
  for (std::int32_t j = 0; j < grid.height; ++j)
    for (std::int32_t i = 0; i < grid.width; ++i)
      if (grid.is_free(i, j) && t.region.contains(i, j)) return;
  throw Error(ErrorKind::input, name + ": the search region has no free cell");
}

void GlobalSearch::State::set_headings(const SearchPrior::Interval& interval, SearchTask& t) const {
  if (!std::isfinite(interval.heading_rad) || !(interval.tolerance_rad >= 0.0))
    throw Error(ErrorKind::input, "search heading: expected a finite angle and a tolerance from 0 up");
  const double step_rad = 2.0 * kPi / t.headings;
  if (interval.tolerance_rad >= kPi) return;
  const double middle = wrap64(interval.heading_rad - T_map_grid.theta_rad);
  // At least the nearest heading on either side.
  const double low = std::floor((middle - interval.tolerance_rad) / step_rad);
  const double high = std::floor((middle + interval.tolerance_rad) / step_rad) + 1.0;
  const auto first = static_cast<std::int32_t>(low);
  t.first_heading = (first % t.headings + t.headings) % t.headings;
  t.heading_count = std::min(t.headings, static_cast<std::int32_t>(high) - first + 1);
}

GlobalSearch::GlobalSearch(const GridMap& map, const SearchConfig& config, const ComputeConfig& compute) {
  validate(config);
  expect(compute.threads >= 0 && compute.threads <= 4096, "threads", "a whole number from 0 to 4096");
  state_ = std::make_unique<State>(map, config, compute);
}
GlobalSearch::~GlobalSearch() = default;
GlobalSearch::GlobalSearch(GlobalSearch&&) noexcept = default;
GlobalSearch& GlobalSearch::operator=(GlobalSearch&&) noexcept = default;

std::vector<LatticePose> GlobalSearch::search_lattice(const BeamTable& beams, const SearchPrior& prior,
                                                      std::size_t most) {
  State& s = *state_;
  make_search_scan(beams, s.resolution_m, s.map.cell_m, s.config, s.scan);
  const SearchTask task = s.task(prior);
  if (s.scan.beams == 0) return {};
  s.backend->search(task, s.scan, s.champions);
  return separate(s.champions, s.map.shape.width, s.map.shape.height, s.scan.headings, s.map.cell_m,
                  s.separation(), most);
}

namespace {

/// The most likely first, those too close to a better one left out, weights as shares of what is left.
std::vector<Hypothesis> rank(std::vector<Hypothesis> all, const Separation& separation,
                             double effective_beams) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.evidence > b.evidence; });
  std::vector<Hypothesis> kept;
  double total = 0.0;
  for (Hypothesis& h : all) {
    const auto apart = [&](const Hypothesis& other) { return separated(h.pose, other.pose, separation); };
    if (!std::all_of(kept.begin(), kept.end(), apart)) continue;
    const double behind = h.evidence - all.front().evidence;
    h.weight = portable_exp(static_cast<float>(effective_beams * behind));
    total += h.weight;
    kept.push_back(h);
  }
  for (Hypothesis& h : kept) h.weight /= total;
  return kept;
}

}  // namespace

SearchResult GlobalSearch::search(const BeamTable& beams, const SearchPrior& prior) {
  State& s = *state_;
  const std::vector<LatticePose> found =
      search_lattice(beams, prior, static_cast<std::size_t>(s.config.candidates));
  SearchResult result;
  result.beams = static_cast<std::size_t>(s.scan.beams);
  result.headings = static_cast<std::size_t>(s.scan.headings);
  result.candidates = found.size();
  std::vector<Hypothesis> all;
  for (const LatticePose& p : found) {
    Pose pose = pose_of(p, s.scan.headings, s.map.cell_m);
    Hypothesis h;
    h.score = s.judge.refine(beams, 2.0 * kPi / s.scan.headings, pose);
    const PoseVerdict judged = s.judge.judge(beams, pose);
    h.explained = judged.explained;
    h.through = judged.through;
    h.unmapped = judged.unmapped;
    h.evidence = judged.evidence;
    h.pose = compose(s.T_map_grid, pose);
    all.push_back(h);
  }
  result.hypotheses = rank(std::move(all), s.separation(), s.config.effective_beams);
  const std::size_t most = static_cast<std::size_t>(s.config.most);
  result.too_many = found.size() == static_cast<std::size_t>(s.config.candidates);
  result.ambiguous = result.too_many;
  for (std::size_t n = 0; n < result.hypotheses.size(); ++n) {
    Hypothesis& h = result.hypotheses[n];
    h.as_good = h.weight >= s.config.ambiguous_share * result.hypotheses[0].weight;
    result.ambiguous = result.ambiguous || (n > 0 && h.as_good);
  }
  if (result.hypotheses.size() > most) result.hypotheses.resize(most);
  return result;
}

SearchResult GlobalSearch::search(const Scan& scan, const ScanConfig& scan_config, const SearchPrior& prior) {
  State& s = *state_;
  BeamCounts counts;
  select_beams(scan, scan_config, default_sensor(SensorModel::beam), s.resolution_m, s.beams, counts);
  return search(s.beams, prior);
}

const SearchMap& GlobalSearch::map() const {
  return state_->map;
}
const SearchScan& GlobalSearch::scan() const {
  return state_->scan;
}
std::string GlobalSearch::backend_name() const {
  return state_->backend->name();
}
const std::string& GlobalSearch::backend_reason() const {
  return state_->why;
}

}  // namespace parloc
