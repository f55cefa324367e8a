#include "tools/bench/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "common/filter/stages.h"
#include "tools/bench/published.h"
#include "tools/bench/recorder.h"
#include "tools/bench/steps/measure.h"
#include "tools/bench/steps/memory.h"

namespace parloc::tools::bench {
namespace {

/// Those of `values` that are not above `most`.
template <class Value>
std::vector<Value> at_most(std::vector<Value> values, Value most) {
  std::erase_if(values, [&](const Value& value) { return value > most; });
  return values;
}

/// Of the 15 sizes, the corners with --quick.
std::vector<std::int64_t> particle_counts(const Plan& plan) {
  std::vector<std::int64_t> all(kPublishedParticles.begin(), kPublishedParticles.end());
  if (plan.quick) all = {kPublishedParticles.front(), kPublishedParticles.back()};
  return at_most(all, plan.max_particles);
}
std::vector<int> beam_counts(const Plan& plan) {
  std::vector<int> all(kPublishedBeams.begin(), kPublishedBeams.end());
  if (plan.quick) all = {kPublishedBeams.front(), kPublishedBeams.back()};
  return at_most(all, plan.max_beams);
}

struct BuiltRig {
  std::size_t variant;
  std::unique_ptr<Rig> rig;
  std::string why;
};

constexpr SensorModel kPeerModels[] = {SensorModel::beam, SensorModel::likelihood_field};
constexpr std::size_t kMostPeerRows = 4;
constexpr int kUsualBeams = 200;
constexpr std::int64_t kLeastParticles = 64;  // of the search for the largest

/// One scene and cloud, with all that the sweeps share.
struct Sweeper {
  const Plan& plan;
  const Scene& scene;
  Cloud cloud;
  Recorder& recorder;
  Results& results;

  Place place() const { return {scene.name, kCloudNames[static_cast<std::size_t>(cloud)]}; }
  Row row(Sweep sweep, std::size_t variant, std::int64_t particles, int beams) const {
    return {sweep, place(), variant, particles, beams, {}, {}};
  }
  int usual_beams() const { return std::min(kUsualBeams, plan.max_beams); }

  void one(Sweep sweep, std::size_t variant, std::int64_t particles, int beams) {
    if (!recorder.go_on()) return;
    std::string why;
    const std::unique_ptr<Rig> rig = recorder.make_rig(scene, cloud, variant, particles, why);
    recorder.measure_row(rig.get(), row(sweep, variant, particles, beams), why);
  }

  void particles(std::size_t variant) {
    for (const std::int64_t n : scale_particles(plan)) one(Sweep::particles, variant, n, usual_beams());
  }
  void beams(std::size_t variant, std::int64_t particles) {
    std::string why;
    const std::unique_ptr<Rig> rig = recorder.make_rig(scene, cloud, variant, particles, why);
    for (const int b : scale_beams(plan))
      recorder.measure_row(rig.get(), row(Sweep::beams, variant, particles, b), why);
  }
  void threads(int all, std::int64_t particles) {
    for (const int k : scale_threads(all, plan.quick)) {
      const std::size_t variant = results.index_of({Algorithm::parloc, BackendChoice::cpu, k, 0});
      one(Sweep::threads, variant, particles, usual_beams());
    }
  }
  std::optional<Bracket> search(Largest& found, std::int64_t most, std::string& why);
  void largest(std::size_t variant, double budget_s);
};

/// Where to begin: the row nearest to the budget, as if time grew in proportion.
std::int64_t first_guess(const Results& results, const Row& wanted, double budget_s) {
  double guess = 10'000.0;
  double nearest = 1e300;
  for (const Row& row : results.rows) {
    if (row.sweep != Sweep::particles || !(row.place == wanted.place) || row.variant != wanted.variant)
      continue;
    const double ratio = std::max(row.time.median_s / budget_s, budget_s / row.time.median_s);
    if (ratio >= nearest) continue;
    nearest = ratio;
    guess = static_cast<double>(row.particles) * budget_s / row.time.median_s;
  }
  return static_cast<std::int64_t>(std::min(guess, 1e9));
}

/// Median and p99 of the largest that fits are kept in `found` on the way.
std::optional<Bracket> Sweeper::search(Largest& found, std::int64_t most, std::string& why) {
  Row wanted = row(Sweep::particles, found.variant, 0, found.beams);
  const auto fits = [&](std::int64_t n) -> std::optional<bool> {
    const std::unique_ptr<Rig> rig = recorder.make_rig(scene, cloud, found.variant, n, why);
    if (rig == nullptr) return std::nullopt;
    wanted.particles = n;
    const std::optional<TimeSummary> time = recorder.measure_alone(*rig, wanted);
    if (!time) return std::nullopt;
    if (time->median_s > found.budget_s) return false;
    found.median_s = time->median_s;
    found.p99_s = time->p99_s;
    return true;
  };
  const double tolerance = plan.quick ? 0.15 : 0.02;
  return largest_that_fits(std::min(kLeastParticles, most), most,
                           first_guess(results, wanted, found.budget_s), tolerance, fits);
}

void Sweeper::largest(std::size_t variant, double budget_s) {
  if (!recorder.go_on()) return;
  const std::string what = fmt::format("{}, {}, the most particles in {:g} ms, {}", scene.name, place().cloud,
                                       1e3 * budget_s, name_of(results.variants[variant]));
  recorder.tell(fmt::format("{} in {:g} ms", scene.name, 1e3 * budget_s));
  const std::int64_t allowed = std::min(plan.max_particles, kMaxParticles);
  const std::int64_t most = particles_in_memory(results.variants[variant], allowed, available_bytes());
  Largest found{place(), variant, usual_beams(), budget_s, 0, 0, "", 0.0, 0.0};
  std::string why = most == 0 ? "there is not enough memory" : "";
  const std::optional<Bracket> bracket = most > 0 ? search(found, most, why) : std::nullopt;
  if (bracket) {
    found.particles = bracket->fits;
    found.too_many = bracket->too_many;
    if (found.too_many == 0) {
      found.limit = most < allowed            ? "memory"
                    : allowed < kMaxParticles ? "--max-particles"
                                              : "the most that parloc takes";
    }
    results.largest.push_back(found);
  } else if (!why.empty()) {
    results.skipped.push_back({what, why});
  }
}

/// Beside other programs: one size, their sensor models, one thread and two.
void measure_peers(const Plan& plan, const Scene& scene, Cloud cloud, Recorder& recorder, Results& results) {
  const Place place{scene.name, kCloudNames[static_cast<std::size_t>(cloud)]};
  for (const SensorModel model : kPeerModels)
    for (const int threads : {1, 2}) {
      if (threads > (plan.threads > 0 ? plan.threads : cores_here()) || !recorder.go_on()) continue;
      const std::size_t variant =
          results.index_of({Algorithm::parloc, BackendChoice::cpu, threads, 0, model});
      std::string why;
      const std::unique_ptr<Rig> rig = recorder.make_rig(scene, cloud, variant, kPeerParticles, why);
      recorder.measure_row(rig.get(), {Sweep::peers, place, variant, kPeerParticles, kPeerBeams, {}, {}},
                           why);
    }
}

/// Whether the plan has the size and the place of the peers' times.
bool has_peers(const Plan& plan, const Scene& scene, Cloud cloud) {
  return scene.name == kPeerScene && cloud == Cloud::tracking && plan.max_particles >= kPeerParticles &&
         plan.max_beams >= kPeerBeams &&
         std::count(plan.algorithms.begin(), plan.algorithms.end(), Algorithm::parloc) > 0;
}

}  // namespace

void measure_tables(const Plan& plan, const std::vector<Scene>& scenes, const Control& control,
                    Results& results) {
  const VariantChoice choice = choose_variants(plan.algorithms, plan.threads);
  results.notes.insert(results.notes.end(), choice.notes.begin(), choice.notes.end());
  const std::vector<std::int64_t> sizes = particle_counts(plan);
  const std::vector<int> beam_sizes = beam_counts(plan);
  Recorder recorder(
      control, results,
      scenes.size() * plan.clouds.size() * choice.variants.size() * sizes.size() * beam_sizes.size() +
          kMostPeerRows);
  for (const Scene& scene : scenes) {
    for (const Cloud cloud : plan.clouds) {
      for (const std::int64_t particles : sizes) {
        std::vector<BuiltRig> rigs;
        for (const Variant& variant : choice.variants) {
          if (!recorder.go_on()) return;
          BuiltRig& built = rigs.emplace_back(BuiltRig{results.index_of(variant), nullptr, ""});
          built.rig = recorder.make_rig(scene, cloud, built.variant, particles, built.why);
        }
        for (const int beams : beam_sizes) {
          for (BuiltRig& r : rigs) {
            const Place place{scene.name, kCloudNames[static_cast<std::size_t>(cloud)]};
            recorder.measure_row(r.rig.get(), {Sweep::tables, place, r.variant, particles, beams, {}, {}},
                                 r.why);
          }
        }
      }
      if (has_peers(plan, scene, cloud)) measure_peers(plan, scene, cloud, recorder, results);
    }
  }
}

std::vector<std::int64_t> scale_particles(const Plan& plan) {
  std::vector<std::int64_t> counts;
  const std::int64_t most = plan.quick ? 65'536 : kMaxParticles;
  for (std::int64_t n = 1024; n <= most; n *= plan.quick ? 8 : 4) counts.push_back(n);
  return at_most(counts, plan.max_particles);
}

std::vector<int> scale_beams(const Plan& plan) {
  const std::vector<int> all =
      plan.quick ? std::vector<int>{50, 200, 1080} : std::vector<int>{50, 100, 200, 360, 541, 720, 1080};
  return at_most(all, plan.max_beams);
}

std::vector<int> scale_threads(int all, bool quick) {
  std::vector<int> counts;
  for (const int k : {1, 2, 3, 4}) counts.push_back(k);
  for (int k = 4; k < all; k *= 2) {
    counts.push_back(k + k / 2);
    counts.push_back(2 * k);
  }
  if (quick) counts = {1};
  counts.push_back(all);
  counts = at_most(counts, all);
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  return counts;
}

void measure_scale(const Plan& plan, const std::vector<Scene>& scenes, const Control& control,
                   Results& results) {
  const int all = plan.threads > 0 ? plan.threads : cores_here();
  VariantChoice choice = cuda_variants();
  choice.variants.insert(choice.variants.begin(), {Algorithm::parloc, BackendChoice::cpu, all, 0});
  if (all == 1) choice.notes.push_back("one core, or --threads 1: nothing to say about threads");
  results.notes.insert(results.notes.end(), choice.notes.begin(), choice.notes.end());

  const std::int64_t some = std::min<std::int64_t>(plan.quick ? 8192 : 65'536, plan.max_particles);
  const std::int64_t few = std::min(kPublishedParticles.back(), plan.max_particles);
  const std::vector<std::int64_t> thread_sizes =
      few == some ? std::vector<std::int64_t>{few} : std::vector<std::int64_t>{few, some};
  const std::size_t per_variant =
      scale_particles(plan).size() + scale_beams(plan).size() + kScaleBudgets_s.size();
  const std::size_t total =
      scenes.size() * plan.clouds.size() *
      (choice.variants.size() * per_variant + thread_sizes.size() * scale_threads(all, plan.quick).size());
  Recorder recorder(control, results, total);
  for (const Scene& scene : scenes) {
    for (const Cloud cloud : plan.clouds) {
      Sweeper sweep{plan, scene, cloud, recorder, results};
      for (const Variant& variant : choice.variants) sweep.particles(results.index_of(variant));
      for (const Variant& variant : choice.variants) sweep.beams(results.index_of(variant), some);
      if (all > 1)
        for (const std::int64_t n : thread_sizes) sweep.threads(all, n);
      for (const Variant& variant : choice.variants)
        for (const double budget_s : kScaleBudgets_s) sweep.largest(results.index_of(variant), budget_s);
    }
  }
}

}  // namespace parloc::tools::bench
