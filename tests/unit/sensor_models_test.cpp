// Sensor models against the check values of SPEC 3.3 and 3.4, against bounds that the early exit relies on,
// and what the models that ask the whole cloud make of a beam that met something off the map.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/config/config.h"
#include "common/filter/beam_votes.h"
#include "common/filter/filter_backend.h"
#include "common/filter/start.h"
#include "common/model/ray_models.h"

namespace parloc {
namespace {

// ---- the tail of the Gaussian --------------------------------------------------------------------

TEST(LogUpperTail, HasTheSpecifiedValues) {
  const double known[][2] = {{0, -0.693147180559945}, {1, -1.84102164500926},  {5, -15.0649983939887},
                             {8, -35.0134371599146},  {10, -53.2312851505125}, {20, -203.917155371097},
                             {40, -804.608442013754}};
  // float32: the value itself is rounded by 6e-8 of its size, twice; its parts by as much of 1.
  for (const auto& [x, log_tail] : known)
    EXPECT_NEAR(portable_log_upper_tail(static_cast<float>(x)), log_tail, 4e-7 - 1.5e-7 * log_tail) << x;
}

TEST(LogUpperTail, StaysWithinItsStatedError) {
  for (float x = 0.0f; x < 37.0f; x += 1e-3f) {  // as far as erfc of double reaches
    const double exact = std::log(0.5 * std::erfc(static_cast<double>(x) / std::sqrt(2.0)));
    ASSERT_NEAR(portable_log_upper_tail(x), exact, 4e-7 - 1.5e-7 * exact) << x;
  }
  EXPECT_NEAR(portable_log_upper_tail(1e6f), -5e11, 1e5);
}

// ---- s5 ------------------------------------------------------------------------------------------

constexpr float kMax_m = 20.0f;

S5Beam spec_s5() {
  SensorConfig c = default_sensor(SensorModel::s5);
  c.sigma_hit = 0.1;
  return bind_s5(c, kMax_m);
}

TEST(S5, HasTheSpecifiedValues) {
  const S5Beam s5 = spec_s5();
  // 19.9f and 19.95f are up to 1e-6 off, which is 1e-5 of sigma; the slope is at most 0.4 per sigma.
  EXPECT_NEAR(std::exp(s5.miss(kMax_m, 19.9f)), 0.158655253931, 4e-6);
  EXPECT_NEAR(std::exp(s5.hit(19.95f, 0.0f, kMax_m)), 0.308537538726, 4e-6);
  EXPECT_NEAR(s5.hit(5.0f, 0.0f, kMax_m), -11255.929618, 2e-3);
  EXPECT_NEAR(s5.miss(kMax_m, kMax_m), -6.907755, 1e-6);
  EXPECT_NEAR(s5.hit(3.0f, 0.0f, 3.0f), std::log(1.0 / (0.1 * std::sqrt(2 * 3.14159265358979))), 1e-6);
  EXPECT_NEAR(s5.hit(3.0f, 0.0f, 3.1f) - s5.hit(3.0f, 0.0f, 3.0f), -0.5, 1e-5);
}

TEST(S5, AnswersEveryPairOfRanges) {
  const S5Beam s5 = spec_s5();
  for (float measured_m = 0.0f; measured_m <= kMax_m; measured_m += 0.25f)
    for (float expected_m = 0.0f; expected_m <= kMax_m; expected_m += 0.25f) {
      ASSERT_TRUE(std::isfinite(s5.hit(measured_m, 0.0f, expected_m)));
      ASSERT_TRUE(std::isfinite(s5.miss(kMax_m, expected_m)));
    }
}

// ---- the censored mixture ------------------------------------------------------------------------

TEST(CensoredBeam, HasTheSpecifiedValues) {
  SensorConfig c = default_sensor(SensorModel::beam);
  c.z_hit = 0.7, c.z_short = 0.1, c.z_max = 0.1, c.z_rand = 0.1, c.sigma_hit = 0.1, c.lambda_short = 0.5;
  const CensoredBeam beam = bind_censored(c, 10.0f);
  const auto hit = [&](float measured_m, float expected_m) {
    const float short_density = 0.1f * 0.5f * std::exp(-0.5f * measured_m);
    return std::exp(beam.hit(measured_m, short_density, expected_m));
  };
  EXPECT_NEAR(hit(3.0f, 3.05f), 2.48871701162, 5e-6);  // (3.05f - 3) / 0.1 is 1e-6 off
  EXPECT_NEAR(hit(2.0f, 3.05f), 0.033510310726, 1e-7);
  EXPECT_NEAR(hit(3.5f, 3.05f), 0.0101118861877, 1e-7);
  EXPECT_NEAR(hit(9.0f, 10.0f), 0.0105592178069, 1e-7);
  EXPECT_NEAR(std::exp(beam.miss(10.0f, 9.95f)), 0.315976277108, 2e-6);
  EXPECT_NEAR(std::exp(beam.miss(10.0f, 3.05f)), 0.1, 1e-7);
  EXPECT_NEAR(std::exp(beam.miss(10.0f, 10.0f)), 0.8, 1e-6);
}

// ---- bounds --------------------------------------------------------------------------------------

class RayModelBounds : public testing::TestWithParam<SensorModel> {};

// A particle is given up when even perfect further beams could not save it: a bound that lies below a value
// that some particle reaches would change the filter's answer.
TEST_P(RayModelBounds, AreNeverBelowAValue) {
  for (const double sigma_m : {0.001, 0.05, 0.2, 3.0})
    for (const double z_short : {0.0, 0.1, 0.5}) {
      SensorConfig c = default_sensor(GetParam());
      c.sigma_hit = sigma_m;
      c.z_hit -= z_short - c.z_short, c.z_short = z_short;
      const RayModels models = bind_ray_models(c, kMax_m);
      with_ray_model(models, GetParam(), [&](const auto& model) {
        // For class_conditional the constant is a share, for beam a density; both are tried over their range.
        for (const float constant : {0.0f, 0.013f, 0.5f, 1.0f})
          for (float measured_m = 0.001f; measured_m < kMax_m; measured_m += 0.171f)
            for (float off_m = -20.0f; off_m <= 20.0f; off_m += 0.0713f) {
              // Near the measured range in the units of sigma too, where the maximum is.
              for (const float expected_m : {measured_m + off_m, measured_m + off_m * 0.01f, measured_m}) {
                if (expected_m < 0.0f) continue;
                const float reached_m = expected_m < kMax_m ? expected_m : kMax_m;
                ASSERT_LE(model.hit(measured_m, constant, reached_m), model.most_of_hit(measured_m, constant))
                    << sigma_m << " " << measured_m << " " << reached_m;
                ASSERT_LE(model.miss(kMax_m, reached_m), model.most_of_miss());
              }
            }
      });
    }
}

INSTANTIATE_TEST_SUITE_P(All, RayModelBounds,
                         testing::Values(SensorModel::gaussian, SensorModel::s5, SensorModel::beam,
                                         SensorModel::class_conditional));

// ---- what the cloud makes of a beam --------------------------------------------------------------

GridMap room() {
  std::vector<std::string> rows(80, std::string(120, '.'));
  for (std::size_t i = 0; i < 120; ++i) rows.front()[i] = rows.back()[i] = '#';
  for (auto& r : rows) r.front() = r.back() = '#';
  return grid_from_text(rows, 0.05);
}
constexpr Pose kHere{3.0, 2.0, 0.4};

double wall_range_m(double bearing_rad) {
  const double c = std::cos(kHere.theta_rad + bearing_rad), s = std::sin(kHere.theta_rad + bearing_rad);
  const double x = c > 0 ? (5.95 - kHere.x_m) / c : (0.05 - kHere.x_m) / c;
  const double y = s > 0 ? (3.95 - kHere.y_m) / s : (0.05 - kHere.y_m) / s;
  return std::min(x, y);
}

/// All around, true to the map, but for `blocked` of every ten beams, which end half way, far from any wall;
/// or without those.
Scan look_around(std::size_t blocked, bool without = false) {
  Scan s{.angle_min_rad = -3.1, .angle_step_rad = 0.07, .range_max_m = 10.0};
  for (std::size_t i = 0; i < 88; ++i) {
    const double range_m = wall_range_m(s.angle_min_rad + static_cast<double>(i) * s.angle_step_rad);
    const bool is_blocked = i % 10 < blocked;
    s.ranges_m.push_back(is_blocked && without ? std::numeric_limits<float>::quiet_NaN()
                                               : static_cast<float>(is_blocked ? 0.5 * range_m : range_m));
  }
  return s;
}

/// Log-weights of a cloud about the true pose after one scan. The step before it makes the filter know that
/// the particles are together.
std::vector<float> log_weights(const SensorConfig& sensor, const Scan& scan, double spread_m = 0.05) {
  const GridMap map = room();
  const FilterBackendConfig c{.particles = 400, .threads = 2, .sensor = sensor};
  const auto backend = make_cpu_filter_backend(c);
  BeamTable beams;
  BeamCounts counts;
  select_beams(scan, ScanConfig{}, sensor, map.resolution_m, beams, counts);
  backend->set_map(map);
  backend->set_range_max(10.0);
  backend->upload(gaussian_start(map, kHere, spread_m, spread_m, 0.02, c.particles, 1));
  backend->normalise_scan();
  backend->estimate();
  backend->set_scan(beams);
  backend->weight(true);
  backend->finish();
  return backend->download().log_weight;
}

SensorConfig beam_skip(bool on = true) {
  SensorConfig c = default_sensor(SensorModel::likelihood_field_prob);
  c.tempering = 1.0;
  c.do_beamskip = on;
  return c;
}

TEST(BeamSkip, LeavesOutWhatFewAgreeWith) {
  EXPECT_EQ(log_weights(beam_skip(), look_around(3)), log_weights(beam_skip(), look_around(3, true)));
}

TEST(BeamSkip, WithoutItTheModelIsTheLikelihoodField) {
  SensorConfig field = default_sensor(SensorModel::likelihood_field);
  field.tempering = 1.0;
  EXPECT_EQ(log_weights(beam_skip(false), look_around(3)), log_weights(field, look_around(3)));
  EXPECT_NE(log_weights(beam_skip(), look_around(3)), log_weights(field, look_around(3)));
}

TEST(BeamSkip, AllBeamsCountIfTooManyWouldBeSkipped) {
  EXPECT_EQ(log_weights(beam_skip(), look_around(10)), log_weights(beam_skip(false), look_around(10)));
  SensorConfig always = beam_skip();
  always.beam_skip_error_threshold = 0.2;
  EXPECT_EQ(log_weights(always, look_around(3)), log_weights(beam_skip(false), look_around(3)));
}

TEST(BeamSkip, AllBeamsCountWhileTheParticlesAreApart) {
  EXPECT_EQ(log_weights(beam_skip(), look_around(3), 0.5),
            log_weights(beam_skip(false), look_around(3), 0.5));
}

TEST(BeamSkip, AgreesWithinTheDistanceAndNowhereOffTheMap) {
  const std::uint32_t squared_cells[] = {0, 1, 4, 9, 16, 25};  // one row, the wall in cell 0
  SensorConfig c = beam_skip();
  c.beam_skip_distance = 0.2;
  const BeamSkip skip = bind_beam_skip(c, squared_cells, 6, 1, 0.05);
  for (int i = 0; i < 6; ++i)  // 4 cells are 0.2 m, which is not within
    EXPECT_EQ(skip.agrees(static_cast<float>(i) + 0.5f, 0.5f), i < 4) << i;
  for (const float off : {-0.5f, -1e9f, 6.0f, 1e9f}) EXPECT_FALSE(skip.agrees(off, 0.5f));
  EXPECT_FALSE(skip.agrees(0.5f, 1.0f));
  EXPECT_FALSE(skip.agrees(0.5f, -0.01f));
}

// The log-weights of the blocked scan as far as they lie from those without its blocked beams: nothing that
// differs between particles may be left of a person.
double spread_about(const std::vector<float>& a, const std::vector<float>& b) {
  double mean = 0.0, square = 0.0;
  const double n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) mean += (a[i] - b[i]) / n;
  for (std::size_t i = 0; i < a.size(); ++i) square += (a[i] - b[i] - mean) * (a[i] - b[i] - mean) / n;
  return std::sqrt(square);
}

SensorConfig with_mixture(SensorModel model) {
  SensorConfig c = default_sensor(SensorModel::class_conditional);
  c.model = model;
  c.sigma_hit = 0.1;
  c.tempering = 0.05;  // so that no weight is zero
  return c;
}

TEST(ClassConditional, AnUnmappedBeamMovesNoParticle) {
  const auto left = [](SensorModel model) {
    return spread_about(log_weights(with_mixture(model), look_around(3)),
                        log_weights(with_mixture(model), look_around(3, true)));
  };
  EXPECT_LT(left(SensorModel::class_conditional), 0.01);
  EXPECT_GT(left(SensorModel::gaussian), 0.5);
}

/// Votes of one particle of weight 1, as shares of the map.
double share_of_map(float measured_m, float expected_m) {
  const ClassConditionalBeam model{
      bind_ray_models(with_mixture(SensorModel::class_conditional), 10.0f).censored};
  const float lambda = model.mixture.lambda;
  const ClassVotes votes =
      class_votes(model, 1.0f, measured_m, 0.2f * lambda * portable_exp(-lambda * measured_m), expected_m);
  return static_cast<double>(votes.map) / (static_cast<double>(votes.map) + votes.unmapped);
}

TEST(ClassConditional, OnlyWhatIsNearerThanTheMapIsUnmapped) {
  EXPECT_GT(share_of_map(4.0f, 4.0f), 0.95);
  EXPECT_GT(share_of_map(3.9f, 4.0f), 0.9);   // one sigma
  EXPECT_LT(share_of_map(3.0f, 4.0f), 0.35);  // ten: what is left is z_rand
  EXPECT_EQ(share_of_map(5.0f, 4.0f), 1.0);   // behind the wall
}

}  // namespace
}  // namespace parloc
