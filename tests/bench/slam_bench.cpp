// How long a step of grid SLAM takes on every backend that answers, and each of its own stages on the CPU.
//   ./slam_bench [--benchmark_filter=propose/scan_match/particles:30] [--benchmark_repetitions=5]
// The robot is half-way through the hall with obstacles (8 m LiDAR, 270 degrees, 180 of its beams). Stages
// have the maps that were made on the way there: each particle beside the true path by its own 2 cm and half
// a degree, resampled at every fifth scan that was taken in. Before every iteration everything that decides
// the work of the next one is restored, outside the clock; only random numbers are new. Cells go on counting,
// and are halved when they are full. RayWall clock; some minutes for all, on a machine with nothing else to
// do.
#include <random>

#include "common/filter/bind.h"
#include "common/model/motion.h"
#include "common/slam/slam_backend.h"
#include "cpu/slam_stages.h"
#include "tests/bench/bench_hall.h"

namespace {

using namespace parloc;
using namespace parloc::bench;

constexpr int kBeams = 180;

/// Scans half a metre or 30 degrees apart; poses from where the first was taken.
struct Drive {
  std::vector<Pose> truth, odometry;
  std::vector<BeamTable> scans;
};

const Drive& drive() {
  static const Drive the_drive = [] {
    const SimulatedLog log = half_way_through_the_hall(541);
    Drive d;
    ScanConfig config;
    config.max_beams = kBeams;
    BeamCounts counts;
    std::size_t scan = 0;
    for (const LogRecord& r : log.records) {
      if (r.kind != RecordKind::scan) continue;
      const Pose truth = relative(log.truth[scan++].pose, log.truth.front().pose);
      if (!d.truth.empty()) {
        const Pose moved = relative(truth, d.truth.back());
        if (std::hypot(moved.x_m, moved.y_m) < 0.5 && std::fabs(moved.theta_rad) < 0.5) continue;
      }
      d.truth.push_back(truth);
      d.odometry.push_back(r.odometry);
      d.scans.emplace_back();
      select_beams(r.scan, config, SensorConfig{}, SlamConfig{}.resolution, d.scans.back(), counts);
    }
    return d;
  }();
  return the_drive;
}

MotionStep motion_to(std::size_t step) {
  const Drive& d = drive();
  if (step == 0) return {};
  return motion_step(odometry_increment(d.odometry[step - 1], d.odometry[step], 0.01), MotionConfig{});
}

/// The particles where the last scan of the drive is taken, before it is written into their maps. They were
/// resampled just before.
class Rig {
 public:
  Rig(std::size_t particles, int threads, SlamProposal proposal = SlamProposal::scan_match)
      : n(particles), random_(1), live_(static_cast<std::uint32_t>(n)) {
    workers.threads = threads;
    for (auto* b : {&poses.x, &poses.y, &poses.theta, &poses.log_weight}) b->resize(n);
    state_.resample = 1;
    SlamConfig config;
    config.proposal = proposal;
    rules = bind_propose_rules(config);
    draw = bind_draw_rules(config);
    for (std::size_t i = 0; i < n; ++i) beside_.push_back({normal(0.02), normal(0.02), normal(0.0087)});
    const std::size_t last = drive().scans.size() - 1;
    for (std::size_t step = 0; step <= last; ++step) {
      place(step);
      cover(config);
      if (step % 5 == 4 || step == last) draw_ancestors(), resample();
      mark(drive().scans[step]);
      if (step == last) break;
      assign();
      register_scan(drive().scans[step]);
    }
    draw_ancestors();
  }

  /// Where the particles are when a scan of the drive is taken.
  void place(std::size_t step) {
    for (std::size_t i = 0; i < n; ++i) {
      const Pose p = compose(drive().truth[step], beside_[i]);
      poses.x[i] = static_cast<float>(p.x_m), poses.y[i] = static_cast<float>(p.y_m);
      poses.theta[i] = static_cast<float>(p.theta_rad);
    }
    likelihood.assign(n, 0.0f);
  }
  void propose(std::uint32_t key) {
    rules.motion = motion_to(drive().scans.size() - 1);
    bind_scan(rules, drive().scans.back(), false);
    input_.motion = rules.motion;
    input_.key = {1, key};
    input_.matched = rules.beams;
    Stages::propose(args(drive().scans.back()), workers);
  }
  void resample() {
    SlamArgs a = args({});
    a.other_table = other_table.data();
    Stages::inherit_tiles(a, store, workers);
    std::swap(table, other_table);
  }
  void mark(const BeamTable& scan) { Stages::mark_tiles(args(scan), workers); }
  void assign() {
    Stages::find_new_tiles(args({}), store, fresh, workers);
    store.make_room(store.used(workers) + fresh.tiles.size(), workers);
    fresh.counted.fits = 1;
    Stages::assign_tiles(args({}), store, fresh, workers);
  }
  void register_scan(const BeamTable& scan) { Stages::register_scan(args(scan), workers); }

  const std::size_t n;
  cpu::Queue workers;
  ProposeRules rules;
  DrawRules draw;
  ParticleSet poses;
  cpu::TileStore store{workers};
  TileSpan span;
  std::vector<float> likelihood;
  std::vector<std::uint32_t> table, other_table, ancestor;
  std::vector<std::uint8_t> touched;
  cpu::NewTiles fresh;

 private:
  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random_); }
  using Stages = cpu::SlamStages;
  SlamArgs args(const BeamTable& scan) {
    input_.scan = scan;
    for (auto* b : {&other_likelihood_, &kept_}) b->resize(n);
    float* const kept = kept_.data();
    return {
        .rules = rules,
        .draw = draw,
        .beams = bind_beams(scan),
        .input = &input_,
        .maps = {span, table.data(), store.pool()},
        .state = &state_,
        .particles = {poses.x.data(), poses.y.data(), poses.theta.data(), poses.log_weight.data(), &live_, n},
        .ancestor = ancestor.data(),
        .likelihood = likelihood.data(),
        .other_likelihood = other_likelihood_.data(),
        .kept = {kept, kept, kept, kept, kept},
        .reach_m = SlamConfig{}.usable_range,
        .tile_m = kTileCells * SlamConfig{}.resolution,
        .touched = touched.data(),
        .tally = fresh.tally()};
  }
  void cover(const SlamConfig& config) {
    const TileSpan grown = grown_span(span, poses.x, poses.y, config.usable_range, config.resolution);
    if (grown.size() == span.size()) return;
    table = moved_tables(table, span, grown, n);
    other_table.assign(table.size(), kNoTile);
    touched.assign(table.size(), 0);
    span = grown;
  }
  /// Of equal weights: about 63 % of the particles are drawn at all.
  void draw_ancestors() {
    ancestor.resize(n);
    for (std::uint32_t& a : ancestor) a = static_cast<std::uint32_t>(random_() % n);
    std::sort(ancestor.begin(), ancestor.end());
  }

  std::mt19937 random_;
  std::uint32_t live_;
  SlamInput input_;
  StepState state_;
  std::vector<float> other_likelihood_, kept_;
  std::vector<Pose> beside_;
};

/// What a stage changes of the tiles' use.
struct Use {
  explicit Use(Rig& rig) : table(rig.table), used(rig.store.used(rig.workers)) {
    refs.assign(rig.store.refs(), rig.store.refs() + rig.store.capacity());
  }
  void restore(Rig& rig) const {
    rig.table = table;
    std::fill(rig.store.refs(), rig.store.refs() + rig.store.capacity(), 0);
    std::copy(refs.begin(), refs.end(), rig.store.refs());
    rig.store.change_used(used, rig.store.used(rig.workers));
  }
  std::vector<std::uint32_t> table, refs;
  std::size_t used;
};

struct Case {
  std::size_t particles;
  int threads;
  SlamProposal proposal = SlamProposal::scan_match;
};

template <class Restore, class Work>
void measure(benchmark::State& state, const Rig& rig, const Restore& restore, const Work& work) {
  time_alone(state, restore, work);
  state.counters["tiles"] = static_cast<double>(rig.store.used(rig.workers));
  count(state, "particles/s", static_cast<double>(rig.n));
}

void propose(benchmark::State& state, const Case& c) {
  Rig rig(c.particles, c.threads, c.proposal);
  std::uint32_t key = 0;
  measure(
      state, rig, [&] { rig.place(drive().scans.size() - 2); }, [&] { rig.propose(key++); });
}
void inherit_tiles(benchmark::State& state, const Case& c) {
  Rig rig(c.particles, c.threads);
  const Use use(rig);
  measure(
      state, rig, [&] { use.restore(rig); }, [&] { rig.resample(); });
}
void mark_tiles(benchmark::State& state, const Case& c) {
  Rig rig(c.particles, c.threads);
  measure(
      state, rig, [] {}, [&] { rig.mark(drive().scans.back()); });
}
/// Just after resampling, when most tiles that the scan comes to are shared and must be copied.
void assign_tiles(benchmark::State& state, const Case& c) {
  Rig rig(c.particles, c.threads);
  const Use use(rig);
  rig.assign();
  measure(
      state, rig, [&] { use.restore(rig); }, [&] { rig.assign(); });
  state.counters["copied"] = static_cast<double>(rig.fresh.tiles.size());
}
void register_scan(benchmark::State& state, const Case& c) {
  Rig rig(c.particles, c.threads);
  rig.assign();
  measure(
      state, rig, [] {}, [&] { rig.register_scan(drive().scans.back()); });
}

/// All that a backend does with a scan: first the drive, then to and fro by 5 cm at its end.
void step(benchmark::State& state, BackendChoice choice, const Case& c) {
  SlamBackendConfig config;
  config.slam.particles = static_cast<std::int64_t>(c.particles);
  config.slam.proposal = c.proposal;
  config.threads = c.threads;
  std::string why;
  const auto backend = make_slam_backend(choice, config, why);
  const Drive& d = drive();
  std::uint32_t key = 0;
  for (; key < d.scans.size(); ++key) backend->step(motion_to(key), {1, key}, d.scans[key]);
  std::size_t resampled = 0;
  bool forward = false;
  for (auto _ : state) {
    forward = !forward;
    const OdometryIncrement moved =
        odometry_increment({0, 0, 0}, {forward ? 0.05 : -0.05, 0, 0}, MotionConfig{}.min_translation_m);
    const SlamStep& done = backend->step(motion_step(moved, MotionConfig{}), {1, key++}, d.scans.back());
    resampled += done.state.resample;
  }
  state.counters["resampled"] = static_cast<double>(resampled) / static_cast<double>(state.iterations());
  state.SetLabel(backend->name());
}

// ---- which of them --------------------------------------------------------------------------------
const char* name_of(SlamProposal p) {
  return p == SlamProposal::motion ? "motion" : p == SlamProposal::gaussian ? "gaussian" : "scan_match";
}

std::string full_name(const std::string& stage, const Case& c) {
  return stage + "/particles:" + std::to_string(c.particles) + "/beams:" + std::to_string(kBeams) +
         "/threads:" + std::to_string(c.threads);
}

/// Given, or the drive would be repeated for every attempt to find out how many are enough.
benchmark::IterationCount iterations(const Case& c) {
  return c.particles < 100 ? 50 : 5;
}

void add(const std::string& name, void (*stage)(benchmark::State&, const Case&), const Case& c) {
  benchmark::RegisterBenchmark(full_name(name, c).c_str(), [=](benchmark::State& state) { stage(state, c); })
      ->UseManualTime()
      ->Iterations(iterations(c))
      ->Unit(benchmark::kMillisecond);
}
void add_step(BackendChoice choice, const Case& c) {
  const std::string name =
      std::string("step/") + name_of(c.proposal) + (choice == BackendChoice::cuda ? "/cuda" : "/cpu");
  benchmark::RegisterBenchmark(full_name(name, c).c_str(),
                               [=](benchmark::State& state) { step(state, choice, c); })
      ->UseRealTime()
      ->Iterations(iterations(c))
      ->Unit(benchmark::kMillisecond);
}

void add_all(const Case& c, bool on_gpu) {
  for (const SlamProposal p : {SlamProposal::motion, SlamProposal::scan_match, SlamProposal::gaussian}) {
    const Case proposing{c.particles, c.threads, p};
    add(std::string("propose/") + name_of(p), propose, proposing);
    add_step(BackendChoice::cpu, proposing);
    if (on_gpu) add_step(BackendChoice::cuda, proposing);
  }
  add("inherit_tiles", inherit_tiles, c);
  add("mark_tiles", mark_tiles, c);
  add("assign_tiles", assign_tiles, c);
  add("register_scan", register_scan, c);
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmarks(argc, argv, [] {
    const bool gpu = cuda_answers();
    for (const std::size_t particles : {30u, 1000u})
      for (const int threads : {1, 2}) add_all({particles, threads}, gpu && threads == 1);
  });
}
