#include "common/search/scan_evidence.h"

#include <algorithm>
#include <utility>

#include "common/filter/start.h"
#include "common/model/ray_models.h"

/// Thousands of fused operations, which are calls where the compiler may not count on the instruction:
/// compiled for it, too, and chosen when the program is loaded. The bits are the same.
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define PARLOC_WITH_FMA __attribute__((flatten, target_clones("fma", "default")))
#else
#define PARLOC_WITH_FMA
#endif

namespace parloc {
namespace {

constexpr std::uint64_t kPlacesSeed = 17;  // any will do
constexpr std::size_t kBins = 256;
constexpr std::size_t kMostChances = 16;  // LiDARs of different reach, remembered at the same time

/// A beam mixture of its own, whatever the filter's model is: the outcome is compared with what was
/// calibrated for it (common/localize/health.h). With much room for what is not on the map: people in front
/// of a wall cost little, a beam that goes through a wall costs much.
SensorConfig evidence_model() {
  SensorConfig c = default_sensor(SensorModel::beam);
  c.z_hit = 0.5, c.z_short = 0.4, c.z_max = 0.05, c.z_rand = 0.05;
  c.sigma_hit = 0.12;
  c.lambda_short = 0.1;  // nearly even up to the wall
  return c;
}

struct Beam {
  explicit Beam(float range_max_m) : config(evidence_model()), model(bind_censored(config, range_max_m)) {}

  float log_hit(float measured_m, float expected_m) const {
    const auto lambda = static_cast<float>(config.lambda_short);
    const float short_density =
        static_cast<float>(config.z_short) * lambda * portable_exp(-lambda * measured_m);
    return model.hit(measured_m, short_density, expected_m);
  }
  float log_miss(float expected_m) const { return model.miss(model.range_max_m, expected_m); }

  SensorConfig config;
  CensoredBeam model;
};

std::size_t bin_of(float range_m, float range_max_m) {
  const float bin = range_m / range_max_m * static_cast<float>(kBins);
  return std::min(static_cast<std::size_t>(max_of(bin, 0.0f)), kBins - 1);
}

float middle_of(std::size_t bin, float range_max_m) {
  return (static_cast<float>(bin) + 0.5f) * range_max_m / static_cast<float>(kBins);
}

/// A reach that is no number is one, too: it is learnt once like any other.
bool same_reach(float a, float b) {
  return a == b || (a != a && b != b);
}

}  // namespace

// Rays go on through unknown cells, whatever the filter's do: maps made on a drive have some along the drive
// itself, and to a robot that stands on one all else would be out of sight.
ScanEvidence::ScanEvidence(const GridMap& map) : rays_(map, false) {
  ParticleSet anywhere = uniform_start(map, kPlaces, kPlacesSeed);
  anywhere_x_m_ = std::move(anywhere.x);
  anywhere_y_m_ = std::move(anywhere.y);
  anywhere_heading_rad_ = std::move(anywhere.theta);
}

PARLOC_WITH_FMA void ScanEvidence::add_place(std::size_t place) {
  const float range_max_m = learning_.range_max_m;
  const Beam beam(range_max_m);
  const float expected_m =
      rays_.cast(anywhere_x_m_[place], anywhere_y_m_[place], anywhere_heading_rad_[place], range_max_m);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const float range_m = middle_of(bin, range_max_m);
    learning_.hit[bin] += static_cast<double>(portable_exp(beam.log_hit(range_m, expected_m)));
  }
  learning_.miss += static_cast<double>(portable_exp(beam.log_miss(expected_m)));
}

ScanEvidence::Chance ScanEvidence::learnt_chance() const {
  const auto log_mean = [&](double sum) {
    return portable_log(static_cast<float>(sum / static_cast<double>(anywhere_x_m_.size())));
  };
  const float range_max_m = learning_.range_max_m;
  Chance chance{range_max_m, std::vector<float>(kBins), std::vector<float>(kBins), log_mean(learning_.miss)};
  const Beam beam(range_max_m);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const float range_m = middle_of(bin, range_max_m);
    chance.log_hit[bin] = log_mean(learning_.hit[bin]);
    chance.best[bin] = beam.log_hit(range_m, range_m) - chance.log_hit[bin];
  }
  return chance;
}

const ScanEvidence::Chance* ScanEvidence::known(float range_max_m) const {
  for (const Chance& chance : chances_)
    if (same_reach(chance.range_max_m, range_max_m)) return &chance;
  return nullptr;
}

std::size_t ScanEvidence::learn(float range_max_m, std::size_t places) {
  if (known(range_max_m) != nullptr) return 0;
  if (learning_.hit.empty() || !same_reach(learning_.range_max_m, range_max_m))
    learning_ = {range_max_m, std::vector<double>(kBins, 0.0), 0.0, 0};
  for (; places > 0 && learning_.places < anywhere_x_m_.size(); --places) add_place(learning_.places++);
  if (learning_.places < anywhere_x_m_.size()) return anywhere_x_m_.size() - learning_.places;
  if (chances_.size() == kMostChances) chances_.erase(chances_.begin());
  chances_.push_back(learnt_chance());
  learning_ = {};
  return 0;
}

PARLOC_WITH_FMA double ScanEvidence::per_beam(const BeamTable& beams, const Pose& pose_in_grid, double lost) {
  attainable_ = 0.0;
  if (beams.count == 0) return 0.0;
  (void)learn(beams.range_max_m, anywhere_x_m_.size());
  const Chance& chance = *known(beams.range_max_m);
  rays_.cast(beams, pose_in_grid, expected_m_);
  const Beam beam(chance.range_max_m);
  const auto hit = [&](float measured_m, float expected_m) {
    return static_cast<double>(beam.log_hit(measured_m, expected_m) -
                               chance.log_hit[bin_of(measured_m, chance.range_max_m)]);
  };
  const auto or_lost = [p = static_cast<float>(lost)](float log_miss) {
    return p > 0.0f ? portable_log(p + (1.0f - p) * portable_exp(log_miss)) : log_miss;
  };
  const float anywhere_miss = or_lost(chance.log_miss);
  const auto miss = [&](float expected_m) {
    return static_cast<double>(or_lost(beam.log_miss(expected_m)) - anywhere_miss);
  };
  double sum = 0.0, most = 0.0;
  for (std::size_t m = 0; m < beams.count; ++m) {
    const float measured_m = beams.range_m[m], expected_m = expected_m_[m];
    sum += m < beams.hits ? hit(measured_m, expected_m) : miss(expected_m);
    const bool in_reach = expected_m < chance.range_max_m;
    const double best = static_cast<double>(chance.best[bin_of(expected_m, chance.range_max_m)]);
    most += in_reach ? (1.0 - lost) * best : miss(expected_m);
    if (in_reach && lost > 0.0) most += lost * miss(expected_m);
  }
  attainable_ = most / static_cast<double>(beams.count);
  return sum / static_cast<double>(beams.count);
}

}  // namespace parloc
