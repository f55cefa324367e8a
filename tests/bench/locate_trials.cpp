// How often, how sure and how fast the global search finds where one scan was taken. Scans are simulated at
// random places of a map, against a finer drawing of it, or taken from a log with known poses.
//   locate_trials --map M.yaml [--fine F.yaml] [--trials 1000] [--fov 360] [--range 8] [--beams 360]
//                 [--noise 0.01] [--seed 1] [--clear 0.3] [--out result.json]
//   locate_trials --map M.yaml --log L --truth T.tum [--range 80] [--trials 200]
// Settings of the search: --sigma, --search-beams, --heading-cells, --least-share, --candidates, --top,
// --effective, --ambiguous, --threads, --scan-beams. --slice 2e6: in slices of so much work, with their
// times;
// --near-m 1 --near-deg 40: within that of the truth. --wall 0.6 or --wall 20: instead of what is seen there
// a flat wall so far away, or one that five beams see.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>

#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/io/trajectory.h"
#include "common/map/map_reader.h"
#include "common/math/philox.h"
#include "common/math/portable64.h"
#include "common/model/beams.h"
#include "common/search/global_search.h"
#include "common/search/search_parts.h"
#include "common/simulator/simulator.h"

namespace parloc {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}

class Options {
 public:
  Options(int argc, char** argv) {
    for (int k = 1; k + 1 < argc; k += 2) values_[argv[k]] = argv[k + 1];
  }
  std::string text(const std::string& name, const std::string& otherwise = "") const {
    const auto at = values_.find(name);
    return at == values_.end() ? otherwise : at->second;
  }
  double number(const std::string& name, double otherwise) const {
    const auto at = values_.find(name);
    return at == values_.end() ? otherwise : std::stod(at->second);
  }

 private:
  std::map<std::string, std::string> values_;
};

struct Trial {
  Scan scan;
  Pose truth;
};

/// Free cells at least clear_m from all that is not free.
std::vector<std::size_t> clear_cells(const GridMap& map, double clear_m) {
  const int reach = static_cast<int>(std::ceil(clear_m / map.resolution_m));
  std::vector<std::size_t> cells;
  for (int j = 0; j < map.height; ++j)
    for (int i = 0; i < map.width; ++i) {
      bool clear = true;
      for (int dj = -reach; clear && dj <= reach; ++dj)
        for (int di = -reach; clear && di <= reach; ++di)
          clear = di * di + dj * dj > reach * reach || map.at(i + di, j + dj) == Cell::free;
      if (clear)
        cells.push_back(static_cast<std::size_t>(j) * static_cast<std::size_t>(map.width) +
                        static_cast<std::size_t>(i));
    }
  return cells;
}

std::vector<Trial> simulated(const Options& o, const GridMap& map, const GridMap& fine) {
  const auto trials = static_cast<std::uint32_t>(o.number("--trials", 1000));
  const double fov_rad = o.number("--fov", 360.0) * kPi / 180.0, range_m = o.number("--range", 8.0);
  const auto beams = static_cast<std::uint32_t>(o.number("--beams", 360));
  const auto seed = static_cast<std::uint64_t>(o.number("--seed", 1));
  const double noise = o.number("--noise", 0.01);
  const std::vector<std::size_t> cells = clear_cells(map, o.number("--clear", 0.3));
  std::vector<Trial> out;
  for (std::uint32_t n = 0; n < trials; ++n) {
    const Philox4x32 r = philox(n, 0, 100, 0, seed);
    const std::size_t cell = cells[uniform_below(r.w[0], static_cast<std::uint32_t>(cells.size()))];
    const auto width = static_cast<std::size_t>(map.width);
    const Pose in_grid{(static_cast<double>(cell % width) + uniform_unit(r.w[1])) * map.resolution_m,
                       (static_cast<double>(cell / width) + uniform_unit(r.w[2])) * map.resolution_m,
                       wrap64(2.0 * kPi * uniform_unit(r.w[3]))};
    Trial t;
    t.truth = compose(map.T_map_grid, in_grid);
    t.scan.angle_min_rad = -0.5 * fov_rad;
    t.scan.angle_step_rad = fov_rad / beams;
    t.scan.range_min_m = 0.1;
    t.scan.range_max_m = range_m;
    for (std::uint32_t b = 0; b < beams; ++b) {
      const double angle_rad = t.truth.theta_rad + t.scan.angle_min_rad + t.scan.angle_step_rad * b;
      const SimulatedHit hit = cast_simulated_ray(fine, t.truth.x_m, t.truth.y_m, angle_rad, range_m);
      const double z = normals(philox(n, 1 + b, 101, 0, seed)).n[0];
      const double measured_m = hit.range_m * (1.0 + noise * z);
      t.scan.ranges_m.push_back(static_cast<float>(hit.hit ? std::min(measured_m, range_m) : range_m));
    }
    out.push_back(t);
  }
  return out;
}

std::vector<Trial> logged(const Options& o) {
  const Trajectory truth = read_tum(o.text("--truth"));
  std::vector<LogRecord> scans;
  const auto log = open_carmen_log(o.text("--log"));
  for (LogRecord record; log->next(record);)
    if (record.kind == RecordKind::scan) scans.push_back(record);
  const auto trials = static_cast<std::size_t>(o.number("--trials", 200));
  std::vector<Trial> out;
  for (std::size_t n = 0; n < trials; ++n) {
    const LogRecord& record = scans[(2 * n + 1) * scans.size() / (2 * trials)];
    // The truth interpolated to the scan's time; rows may be unordered by tiny amounts.
    const StampedPose *before = nullptr, *after = nullptr;
    for (const StampedPose& row : truth) {
      if (row.stamp_s <= record.stamp_s && (before == nullptr || row.stamp_s > before->stamp_s))
        before = &row;
      if (row.stamp_s >= record.stamp_s && (after == nullptr || row.stamp_s < after->stamp_s)) after = &row;
    }
    if (before == nullptr || after == nullptr || after->stamp_s - before->stamp_s > 1.6) continue;
    const double gap_s = after->stamp_s - before->stamp_s;
    const double part = gap_s > 0.0 ? (record.stamp_s - before->stamp_s) / gap_s : 0.0;
    const Pose step = relative(after->pose, before->pose);
    out.push_back(
        {record.scan, compose(before->pose, {part * step.x_m, part * step.y_m, part * step.theta_rad})});
    out.back().scan.range_max_m = o.number("--range", 80.0);
  }
  return out;
}

/// What fits nearly everywhere takes longest: a wall at `ahead_m`, seen by 180 beams if it is near and by 5
/// if not.
Scan flat_wall(double ahead_m, double range_m) {
  Scan scan;
  const int beams = ahead_m < 5.0 ? 180 : 5;
  scan.angle_min_rad = -0.5;
  scan.angle_step_rad = 1.0 / beams;
  scan.range_min_m = 0.1;
  scan.range_max_m = std::max(range_m, 2.0 * ahead_m);
  for (int b = 0; b < beams; ++b)
    scan.ranges_m.push_back(
        static_cast<float>(ahead_m / std::cos(scan.angle_min_rad + scan.angle_step_rad * b)));
  return scan;
}

bool right(const Pose& a, const Pose& truth) {
  return std::hypot(a.x_m - truth.x_m, a.y_m - truth.y_m) <= 0.5 &&
         std::fabs(wrap64(a.theta_rad - truth.theta_rad)) <= 10.0 * kPi / 180.0;
}

struct Tally {
  int trials = 0, right = 0, among = 0, ambiguous = 0, none = 0, sure_and_wrong = 0, sure_and_right = 0;
  int covered = 0;                           // right, or ambiguous with the truth among the hypotheses
  std::vector<double> seconds, cpu_seconds;  // wall clock; all threads together
  std::vector<double> slices, slice_ms;      // by search; of every slice, all threads together
  static double at(std::vector<double> times, double share) {
    std::sort(times.begin(), times.end());
    const auto n = static_cast<std::size_t>(share * static_cast<double>(times.size()));
    return times[std::min(times.size() - 1, n)];
  }
};

void report(const Options& o, Tally& t, double built_s, const GlobalSearch& search, double free_m2) {
  const auto percent = [&](int n) { return 100.0 * n / std::max(1, t.trials); };
  fmt::print("{} trials, {:.0f} m2 free, {}, built in {:.3f} s\n", t.trials, free_m2, search.backend_name(),
             built_s);
  fmt::print("seconds: median {:.4f}, 95 % {:.4f}, most {:.4f}\n", t.at(t.seconds, 0.5),
             t.at(t.seconds, 0.95), t.at(t.seconds, 1.0));
  fmt::print("CPU seconds, all threads: median {:.5f}, 95 % {:.5f}, most {:.5f}\n", t.at(t.cpu_seconds, 0.5),
             t.at(t.cpu_seconds, 0.95), t.at(t.cpu_seconds, 1.0));
  if (!t.slices.empty())
    fmt::print(
        "slices: median {:.0f}, most {:.0f} in a search; CPU ms each: median {:.2f}, 99 % {:.2f}, most "
        "{:.2f}\n",
        t.at(t.slices, 0.5), t.at(t.slices, 1.0), t.at(t.slice_ms, 0.5), t.at(t.slice_ms, 0.99),
        t.at(t.slice_ms, 1.0));
  fmt::print(
      "right {:.1f} %, truth among them {:.1f} %, ambiguous {:.1f} %, sure and right {:.1f} %, sure and "
      "wrong "
      "{:.2f} % ({}), none {:.1f} %, right or (ambiguous with the truth among them) {:.1f} %\n",
      percent(t.right), percent(t.among), percent(t.ambiguous), percent(t.sure_and_right),
      percent(t.sure_and_wrong), t.sure_and_wrong, percent(t.none), percent(t.covered));
  const std::string path = o.text("--out");
  if (path.empty()) return;
  std::ofstream(path) << fmt::format(
      "{{\"map\": \"{}\", \"log\": \"{}\", \"fov_deg\": {}, \"range_m\": {}, \"trials\": {}, \"free_m2\": "
      "{:.1f}, \"backend\": \"{}\", \"built_s\": {:.4f}, \"median_s\": {:.4f}, \"p95_s\": {:.4f}, "
      "\"most_s\": "
      "{:.4f}, \"cpu_median_s\": {:.4f}, \"cpu_p95_s\": {:.4f}, \"cpu_most_s\": {:.4f}, \"right\": {}, "
      "\"among\": {}, \"ambiguous\": {}, \"sure_and_right\": {}, \"sure_and_wrong\": "
      "{}, "
      "\"none\": {}}}\n",
      o.text("--map"), o.text("--log"), o.number("--fov", 360), o.number("--range", 8), t.trials, free_m2,
      search.backend_name(), built_s, t.at(t.seconds, 0.5), t.at(t.seconds, 0.95), t.at(t.seconds, 1.0),
      t.at(t.cpu_seconds, 0.5), t.at(t.cpu_seconds, 0.95), t.at(t.cpu_seconds, 1.0), t.right, t.among,
      t.ambiguous, t.sure_and_right, t.sure_and_wrong, t.none);
}

SearchConfig config_of(const Options& o) {
  SearchConfig c;
  c.sigma_m = o.number("--sigma", c.sigma_m);
  c.beams = static_cast<int>(o.number("--search-beams", c.beams));
  c.heading_cells = o.number("--heading-cells", c.heading_cells);
  c.max_headings = static_cast<int>(o.number("--max-headings", c.max_headings));
  c.least_share = o.number("--least-share", c.least_share);
  c.least_score = o.number("--least-score", c.least_score);
  c.candidates = static_cast<int>(o.number("--candidates", c.candidates));
  c.most = static_cast<int>(o.number("--top", c.most));
  c.effective_beams = o.number("--effective", c.effective_beams);
  c.ambiguous_share = o.number("--ambiguous", c.ambiguous_share);
  return c;
}

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

SearchPrior near_truth(const Options& o, const Pose& truth) {
  SearchPrior prior;
  const double radius_m = o.number("--near-m", 0.0), tolerance_deg = o.number("--near-deg", 0.0);
  if (radius_m > 0.0) prior.region = {{truth.x_m, truth.y_m, radius_m}};
  if (tolerance_deg > 0.0) prior.heading = {{truth.theta_rad, tolerance_deg * kPi / 180.0}};
  return prior;
}

SearchResult search_one(const Options& o, GlobalSearch& search, const BeamTable& beams,
                        const SearchPrior& prior, Tally& tally) {
  const auto work = static_cast<std::int64_t>(o.number("--slice", 0.0));
  if (work <= 0) return search.search(beams, prior);
  search.begin(beams, prior);
  double slices = 0.0;
  for (bool done = false; !done; ++slices) {
    const double start_s = cpu_seconds();
    done = search.advance(work);
    tally.slice_ms.push_back(1e3 * (cpu_seconds() - start_s));
  }
  tally.slices.push_back(slices);
  return search.result();
}

int run(const Options& o) {
  const GridMap map = read_map(o.text("--map"));
  std::vector<Trial> trials;
  if (o.text("--log").empty())
    trials = simulated(o, map, o.text("--fine").empty() ? map : read_map(o.text("--fine")));
  else
    trials = logged(o);
  const Clock::time_point begun = Clock::now();
  GlobalSearch search(map, config_of(o), {.threads = static_cast<int>(o.number("--threads", 0))});
  const double built_s = seconds_since(begun);
  ScanConfig scan_config;
  scan_config.max_beams = static_cast<int>(o.number("--scan-beams", 180));
  if (const double ahead_m = o.number("--wall", 0.0); ahead_m > 0.0)
    for (Trial& t : trials) t.scan = flat_wall(ahead_m, o.number("--range", 8.0));
  BeamTable beams;
  BeamCounts counts;
  Tally tally;
  const bool verbose = !o.text("--verbose").empty();
  for (const Trial& t : trials) {
    const double cpu_start_s = cpu_seconds();
    const Clock::time_point start = Clock::now();
    select_beams(t.scan, scan_config, default_sensor(SensorModel::beam), map.resolution_m, beams, counts);
    const SearchResult r = search_one(o, search, beams, near_truth(o, t.truth), tally);
    tally.seconds.push_back(seconds_since(start));
    tally.cpu_seconds.push_back(cpu_seconds() - cpu_start_s);
    ++tally.trials;
    const bool first = !r.hypotheses.empty() && right(r.hypotheses[0].pose, t.truth);
    const bool among = std::any_of(r.hypotheses.begin(), r.hypotheses.end(),
                                   [&](const Hypothesis& h) { return right(h.pose, t.truth); });
    tally.right += first ? 1 : 0;
    tally.among += among ? 1 : 0;
    tally.none += r.hypotheses.empty() ? 1 : 0;
    tally.ambiguous += r.ambiguous ? 1 : 0;
    tally.covered += first || (r.ambiguous && among) ? 1 : 0;
    tally.sure_and_right += first && !r.ambiguous ? 1 : 0;
    tally.sure_and_wrong += !first && !r.ambiguous && !r.hypotheses.empty() ? 1 : 0;
    if (verbose) {
      fmt::print("truth {:.2f} {:.2f} {:.3f}  {}{} {:.3f} s, {} candidates\n", t.truth.x_m, t.truth.y_m,
                 t.truth.theta_rad, first ? "right" : "WRONG", r.ambiguous ? " ambiguous" : "",
                 tally.seconds.back(), r.candidates);
      for (const Hypothesis& h : r.hypotheses)
        fmt::print(
            "   {:.2f} {:.2f} {:.3f} score {:.3f} explained {:.3f} through {:.3f} unmapped {:.3f} ll {:.3f} "
            "w {:.3f}\n",
            h.pose.x_m, h.pose.y_m, h.pose.theta_rad, h.score, h.explained, h.through, h.unmapped, h.evidence,
            h.weight);
    }
  }
  if (tally.trials == 0) throw Error(ErrorKind::input, "no trial: the log and the truth do not overlap");
  report(o, tally, built_s, search,
         static_cast<double>(SearchParts(search).map().free_count) * SearchParts(search).map().cell_m *
             SearchParts(search).map().cell_m);
  return 0;
}

}  // namespace
}  // namespace parloc

int main(int argc, char** argv) {
  try {
    return parloc::run(parloc::Options(argc, argv));
  } catch (const std::exception& e) {
    fmt::print(stderr, "locate_trials: {}\n", e.what());
    return 1;
  }
}
