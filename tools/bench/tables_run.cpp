#include "tools/bench/plan.h"

#include <cstddef>
#include <memory>
#include <string>

#include "tools/bench/published.h"
#include "tools/bench/recorder.h"

namespace parloc::tools::bench {
namespace {

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

}  // namespace

void measure_tables(const Plan& plan, const std::vector<Scene>& scenes, const Control& control,
                    Results& results) {
  const VariantChoice choice = choose_variants(plan.algorithms, plan.threads);
  results.notes.insert(results.notes.end(), choice.notes.begin(), choice.notes.end());
  const std::vector<std::int64_t> sizes = particle_counts(plan);
  const std::vector<int> beam_sizes = beam_counts(plan);
  Recorder recorder(
      control, results,
      scenes.size() * plan.clouds.size() * choice.variants.size() * sizes.size() * beam_sizes.size());
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
    }
  }
}

}  // namespace parloc::tools::bench
