// How long a step of the filter takes, and each of its stages alone, on every backend of this build that
// answers.
//   ./stage_bench [--benchmark_filter=step/gaussian/skip/cpu/particles:4000] [--benchmark_repetitions=5]
// Particles track a robot in the hall with obstacles: normal around the true pose (0.2 m, 0.1 rad), 8 m
// LiDAR, 270 degrees, a scan simulated against the map of 1 cm. Before every iteration everything that the
// last one changed is restored, outside the clock, so that all iterations do the same work; only random
// numbers are new each time, or the branch predictor would know 4000 of them by heart. The clock runs
// until finish() has returned, that is until a device is done. Times are wall clock (UseManualTime).
#include <map>

#include "common/filter/bind.h"
#include "common/filter/start.h"
#include "common/map/grid_map.h"
#include "common/map/rays/skip_field.h"
#include "cpu/stages.h"
#include "tests/bench/bench_hall.h"

namespace {

using namespace parloc;
using namespace parloc::bench;

const Place& hall() {
  static const Place place = hall_with_scan(541);
  return place;
}

/// A hall of the same size whose 64 walls are segments: the outline and 15 boxes; each cut into `pieces`.
const Place& hall_of_segments(int pieces) {
  static std::map<int, Place> places;
  Place& p = places[pieces];
  if (!p.map.walls.empty()) return p;
  p = hall();
  p.map.cells.assign(p.map.size(), Cell::free);
  const auto wall = [&](float ax, float ay, float bx, float by) {
    for (int k = 0; k < pieces; ++k) {
      const float from = static_cast<float>(k) / static_cast<float>(pieces);
      const float to = static_cast<float>(k + 1) / static_cast<float>(pieces);
      p.map.walls.push_back(
          {ax + from * (bx - ax), ay + from * (by - ay), ax + to * (bx - ax), ay + to * (by - ay)});
    }
  };
  const auto box = [&](float x, float y, float width, float height) {
    wall(x, y, x + width, y), wall(x + width, y, x + width, y + height);
    wall(x + width, y + height, x, y + height), wall(x, y + height, x, y);
  };
  box(0.125f, 0.125f, 19.75f, 9.75f);  // as read_map lays its grid: round coordinates in the middle of cells
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 3; ++j)
      box(1.525f + 4.0f * static_cast<float>(i), 1.025f + 3.4f * static_cast<float>(j), 0.6f, 0.4f);
  for (std::size_t k = 0; k < p.scan.ranges_m.size(); ++k) {
    const double bearing_rad = p.scan.angle_min_rad + static_cast<double>(k) * p.scan.angle_step_rad;
    const Pose ray = compose(compose(p.pose, p.scan.T_base_sensor), {0, 0, bearing_rad});
    const SimulatedHit hit = cast_simulated_ray(p.map, ray.x_m, ray.y_m, ray.theta_rad, p.scan.range_max_m);
    p.scan.ranges_m[k] = static_cast<float>(hit.range_m);
  }
  return p;
}

struct Case {
  BackendChoice backend = BackendChoice::cpu;
  SensorConfig sensor;
  std::int64_t particles = 0;
  int beams = 0;
  int threads = 1;
  int pieces = 0;                  ///< 0: the hall as a grid; else of segments, each wall cut into as many.
  std::int64_t min_particles = 0;  ///< 0: their number is fixed.
  KldConfig kld{};
  const Place& place() const { return pieces == 0 ? hall() : hall_of_segments(pieces); }
};

/// A backend with the map, a scan and a cloud of particles.
class Rig {
 public:
  explicit Rig(const Case& c) : config_(c) {
    const Place& place = c.place();
    FilterBackendConfig config;
    config.particles = c.particles;
    config.threads = c.threads;
    config.sensor = c.sensor;
    config.min_particles = c.min_particles;
    config.kld = c.kld;
    backend = make_filter_backend(c.backend, config, why_);
    backend->set_map(place.map);
    ScanConfig scan_config;
    scan_config.max_beams = c.beams;
    BeamCounts counts;
    select_beams(place.scan, scan_config, c.sensor, place.map.resolution_m, beams, counts);
    backend->set_range_max(beams.range_max_m);
    cloud = gaussian_start(place.map, place.pose, 0.2, 0.2, 0.1, c.particles, 1);
    backend->upload(cloud);  // and once through all stages: the first step allocates
    backend->set_scan(beams);
    backend->predict(motion, next_key());
    backend->weight(true);
    backend->finish();
    weighed = backend->download();
    backend->normalise_scan();
    backend->estimate();
    backend->adapt(next_key(), false);
    backend->resample(next_key());
    last = backend->finish();
  }

  /// Times `work`; `restore` runs before each iteration, outside the clock.
  template <class Restore, class Work>
  void measure(benchmark::State& state, const Restore& restore, const Work& work) {
    time_alone(
        state, [&] { restore(), backend->finish(); }, [&] { work(), last = backend->finish(); });
    count(state, "particles/s", static_cast<double>(config_.particles));
    state.SetLabel(backend->name());
  }
  void count_rays(benchmark::State& state) const {
    count(state, "rays/s", static_cast<double>(config_.particles) * static_cast<double>(beams.count));
  }

  RandomKey next_key() { return {1, step_++}; }

  std::unique_ptr<FilterBackend> backend;
  BeamTable beams;
  ParticleSet cloud;    ///< Before a step.
  ParticleSet weighed;  ///< After predict and weight.
  StepState last;       ///< Of the last step or stage.
  const MotionStep motion =
      motion_step(odometry_increment({0, 0, 0}, {0.05, 0.0, 0.02}, 0.01), MotionConfig{});

 private:
  Case config_;
  std::string why_;
  std::uint32_t step_ = 0;
};

// ---- the stages ---------------------------------------------------------------------------------
void predict(benchmark::State& state, const Case& c) {
  Rig rig(c);
  rig.measure(
      state, [&] { rig.backend->upload(rig.cloud); },
      [&] { rig.backend->predict(rig.motion, rig.next_key()); });
}

/// The stage of the CPU backend into an array that is there already.
void ray_trace(benchmark::State& state, const Case& c) {
  Rig rig(c);
  const GridMap& map = hall().map;
  const SkipField skip = skip_field(blocking_cells(map, c.sensor.unknown_blocks).data(), map.width,
                                    map.height, std::size_t{64} << 20);
  ParticleSet& set = rig.weighed;
  std::uint32_t count = static_cast<std::uint32_t>(set.x.size());
  std::vector<float> expected_m(set.x.size() * rig.beams.count);
  RayTraceArgs args =
      bind_rays({set.x.data(), set.y.data(), set.theta.data(), set.log_weight.data(), &count, count},
                bind_ray_map(skip.lines.data(), skip.planes, map), bind_beams(rig.beams), c.sensor);
  StepInput input;
  input.scan = rig.beams;
  args.input = &input;
  args.expected_m = expected_m.data();
  cpu::Queue workers;
  workers.threads = c.threads;
  rig.measure(
      state, [] {}, [&] { cpu::FilterStages::ray_trace(args, workers); });
  rig.count_rays(state);
}

/// Of any backend, with the allocation and the download of the ranges: no part of a step.
void ray_trace_and_download(benchmark::State& state, const Case& c) {
  Rig rig(c);
  rig.backend->upload(rig.weighed);
  rig.measure(
      state, [] {}, [&] { benchmark::DoNotOptimize(rig.backend->ray_trace().data()); });
  rig.count_rays(state);
}

void weight(benchmark::State& state, const Case& c) {
  Rig rig(c);
  rig.measure(
      state, [&] { rig.backend->upload(rig.cloud); }, [&] { rig.backend->weight(true); });
  rig.count_rays(state);
}

void normalise_scan(benchmark::State& state, const Case& c) {
  Rig rig(c);
  rig.measure(
      state, [&] { rig.backend->upload(rig.weighed); }, [&] { rig.backend->normalise_scan(); });
}

/// Changes neither poses nor weights.
void estimate(benchmark::State& state, const Case& c) {
  Rig rig(c);
  rig.backend->upload(rig.weighed);
  rig.backend->normalise_scan();
  rig.measure(
      state, [] {}, [&] { rig.backend->estimate(); });
}

/// Puts back the weights of a scan in tracking, which ask for resampling.
auto weighed_again(Rig& rig) {
  return [&rig] {
    rig.backend->upload(rig.weighed);
    rig.backend->normalise_scan();
  };
}

/// How many particles the next set gets; with the weights of a scan in tracking, which ask for a new one.
void adapt(benchmark::State& state, const Case& c) {
  Rig rig(c);
  if (rig.last.resample == 0) return state.SkipWithError("the weights do not ask for resampling");
  rig.measure(state, weighed_again(rig), [&] { rig.backend->adapt(rig.next_key(), false); });
  state.counters["chosen"] = rig.last.next_count;
}

/// The weights of a scan in tracking, of which N_eff is low: particles are drawn in every iteration.
void resample(benchmark::State& state, const Case& c) {
  Rig rig(c);
  if (rig.last.resample == 0) return state.SkipWithError("the weights do not ask for resampling");
  rig.measure(state, weighed_again(rig), [&] { rig.backend->resample(rig.next_key()); });
}

/// All that a backend does per scan, the upload of the scan and the download of the estimate included.
void step(benchmark::State& state, const Case& c) {
  Rig rig(c);
  rig.measure(
      state, [&] { rig.backend->upload(rig.cloud); },
      [&] {
        rig.backend->predict(rig.motion, rig.next_key());
        rig.backend->set_scan(rig.beams);
        rig.backend->weight(true);
        rig.backend->normalise_scan();
        rig.backend->estimate();
        rig.backend->resample(rig.next_key());
      });
  rig.count_rays(state);
  state.counters["resampled"] = rig.last.resample;
}

// ---- which of them ------------------------------------------------------------------------------
struct Size {
  std::int64_t particles;
  int beams;
};
constexpr Size kUsual{4000, 200}, kSmall{500, 50}, kLarge{100'000, 200};

const char* name_of(SensorModel model) {
  return model == SensorModel::gaussian ? "gaussian"
         : model == SensorModel::beam   ? "beam"
                                        : "likelihood_field";
}
const char* name_of(RayCaster caster) {
  return caster == RayCaster::skip ? "skip" : caster == RayCaster::dda ? "dda" : "fixed_step";
}

void add(const std::string& name, void (*stage)(benchmark::State&, const Case&), Case c, Size size) {
  c.particles = size.particles;
  c.beams = size.beams;
  std::string full = name + (c.backend == BackendChoice::cpu ? "/cpu" : "/cuda") +
                     "/particles:" + std::to_string(c.particles) + "/beams:" + std::to_string(c.beams);
  if (c.backend == BackendChoice::cpu) full += "/threads:" + std::to_string(c.threads);
  benchmark::RegisterBenchmark(full.c_str(), [=](benchmark::State& state) { stage(state, c); })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

void add_sensor_stages(Case c, SensorModel model, RayCaster caster) {
  c.sensor = default_sensor(model);
  c.sensor.caster = caster;
  const bool casts = model != SensorModel::likelihood_field;
  const std::string tail =
      std::string("/") + name_of(model) + (casts ? "/" : "") + (casts ? name_of(caster) : "");
  for (const Size size : {kUsual, kSmall, kLarge}) {
    if (size.particles > kUsual.particles && caster != RayCaster::skip) continue;  // seconds per iteration
    if (model == SensorModel::gaussian) {  // ranges do not depend on the model
      const std::string name = std::string("/") + name_of(caster);
      if (c.backend == BackendChoice::cpu) add("ray_trace" + name, ray_trace, c, size);
      if (c.backend == BackendChoice::cuda)
        add("ray_trace_and_download" + name, ray_trace_and_download, c, size);
    }
    add("weight" + tail, weight, c, size);
    add("step" + tail, step, c, size);
  }
}

/// `tracking`: as a filter does it, few bins. `most`: bins so small that hardly two candidates share one, and
/// as many are drawn as there can be.
void add_adapt(Case c, Size size) {
  c.min_particles = 100;
  add("adapt/tracking", adapt, c, size);
  c.kld.bin_size_xy = 0.001;
  c.kld.bin_size_theta = 0.001;
  add("adapt/most", adapt, c, size);
}

void add_backend(BackendChoice backend, int threads) {
  Case c;
  c.backend = backend;
  c.threads = threads;
  c.sensor = default_sensor(SensorModel::gaussian);
  for (const Size size : {kUsual, kSmall, kLarge}) {
    add("predict", predict, c, size);
    add("normalise_scan", normalise_scan, c, size);
    add("estimate", estimate, c, size);
    add("resample", resample, c, size);
    add_adapt(c, size);
  }
  for (const SensorModel model : {SensorModel::gaussian, SensorModel::beam})
    for (const RayCaster caster : {RayCaster::skip, RayCaster::dda, RayCaster::fixed_step})
      add_sensor_stages(c, model, caster);
  add_sensor_stages(c, SensorModel::likelihood_field, RayCaster::skip);
  for (const RayCaster caster : {RayCaster::skip, RayCaster::dda}) {  // dda: tries every wall
    for (const int pieces : {1, 156}) {                               // 64 and 9984 walls
      if (caster == RayCaster::dda && pieces > 1) continue;
      Case segments = c;
      segments.pieces = pieces;
      segments.sensor.caster = caster;
      const std::string walls = std::string("/walls:") + std::to_string(64 * pieces) + "/" + name_of(caster);
      add("weight/gaussian" + walls, weight, segments, kUsual);
      add("step/gaussian" + walls, step, segments, kUsual);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmarks(argc, argv, [] {
    std::string devices;
    for (const std::string& line : describe_devices()) devices += (devices.empty() ? "" : "; ") + line;
    benchmark::AddCustomContext("devices", devices);
    for (const int threads : {1, 2}) add_backend(BackendChoice::cpu, threads);
    if (cuda_answers()) add_backend(BackendChoice::cuda, 1);
  });
}
