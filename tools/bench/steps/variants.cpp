#include "tools/bench/steps/variants.h"

#include <fmt/format.h>

#include <exception>

#include "common/map/grid_map.h"
#include "common/model/model_settings.h"
#include "tools/report/machine/machine.h"

namespace parloc::tools::bench {
namespace {

#if PARLOC_WITH_CUDA
/// A step of 64 particles: a device that is too old for this build, or broken, fails here.
void try_step(const Variant& variant) {
  std::string why;
  const std::unique_ptr<FilterBackend> backend =
      make_filter_backend(BackendChoice::cuda, backend_config(variant, 64), why);
  backend->set_map(grid_from_text({"####", "#..#", "#..#", "####"}, 0.5));
  ParticleSet set;
  for (auto* v : {&set.x, &set.y}) v->assign(64, 1.0f);
  for (auto* v : {&set.theta, &set.log_weight}) v->assign(64, 0.0f);
  backend->upload(set);
  backend->predict({}, {1, 0});
  backend->normalise_scan();
  backend->estimate();
  backend->finish();
}
#endif

}  // namespace

std::string place_of(const Variant& v) {
  if (v.backend == BackendChoice::cuda) return fmt::format("cuda {}", v.device);
  return fmt::format("{} thread{}", v.threads, v.threads == 1 ? "" : "s");
}

std::string name_of(const Variant& v) {
  const std::string model =
      v.model == SensorModel::gaussian ? "" : fmt::format("{} model, ", name_of(v.model, kSensorModels));
  return fmt::format("{}, {}{}", kAlgorithmNames[static_cast<std::size_t>(v.algorithm)], model, place_of(v));
}

FilterBackendConfig backend_config(const Variant& v, std::int64_t particles) {
  const bool paz2012 = v.algorithm == Algorithm::paz2012;
  FilterBackendConfig config;
  config.particles = particles;
  config.threads = v.threads;
  config.device = v.device;
  config.sensor = default_sensor(v.model);
  if (v.model == SensorModel::gaussian) {
    config.sensor.sigma_hit = 0.1;
    config.sensor.tempering = 1.0;
  }
  config.sensor.caster = paz2012 ? RayCaster::fixed_step : RayCaster::skip;
  config.sensor.fixed_step_cells = 0.5;
  config.resample.scheme = paz2012 ? ResampleScheme::multinomial_linear : ResampleScheme::systematic;
  config.resample.threshold = 1.0;  // every step
  return config;
}

VariantChoice cuda_variants() {
  VariantChoice choice;
#if PARLOC_WITH_CUDA
  const int devices = cuda_device_count();
  if (devices == 0)
    choice.notes.push_back("no GPU is measured: no CUDA device answers (no GPU, or no driver)");
  for (int device = 0; device < devices; ++device) {
    const Variant variant{Algorithm::parloc, BackendChoice::cuda, 1, device};
    try {
      try_step(variant);
      choice.variants.push_back(variant);
    } catch (const std::exception& e) {
      choice.notes.push_back(fmt::format("cuda {} is not measured: {}", device, e.what()));
    }
  }
#else
  choice.notes.push_back("no GPU is measured: this build has no CUDA backend");
#endif
  return choice;
}

VariantChoice choose_variants(const std::vector<Algorithm>& algorithms, int threads) {
  const int all = threads > 0 ? threads : cores_here();
  VariantChoice choice;
  if (all == 1) choice.notes.push_back("one core, or --threads 1: only one thread is measured");
  bool parloc = false;
  for (const Algorithm algorithm : algorithms) {
    choice.variants.push_back({algorithm, BackendChoice::cpu, 1, 0});
    if (all > 1) choice.variants.push_back({algorithm, BackendChoice::cpu, all, 0});
    parloc = parloc || algorithm == Algorithm::parloc;
  }
  if (!parloc) return choice;
  const VariantChoice cuda = cuda_variants();
  choice.variants.insert(choice.variants.end(), cuda.variants.begin(), cuda.variants.end());
  choice.notes.insert(choice.notes.end(), cuda.notes.begin(), cuda.notes.end());
  return choice;
}

}  // namespace parloc::tools::bench
