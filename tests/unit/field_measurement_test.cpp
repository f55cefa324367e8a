// The distance field between cells and what a scan makes of it: the check values of SPEC 7.1 to 7.3, and
// slopes against numerical differentiation.
#include "common/flow/field_measurement.h"

#include <gtest/gtest.h>

#include <random>

#include "common/flow/kalman_update.h"
#include "common/math/portable.h"
#include "tests/unit/flow_scenes.h"
#include "tests/unit/small_drive.h"

namespace parloc {
namespace {

using test::kNoCap_m;
using test::MapField;

// A step computes in float32: a value of size 1 is good to some 1e-7, and sums of a few such to 1e-6.
constexpr double kFloat = 1e-6;

FieldValue field_at(const DistanceField& field, double x_m, double y_m) {  // map frame of T1
  const float u = static_cast<float>((x_m + 1.0) / 0.5 - 0.5),
              v = static_cast<float>((y_m + 2.0) / 0.5 - 0.5);
  ScanPose here{u, v, 1.0f, 0.0f};
  return look_up(field, here, {0.0f, 0.0f});
}

TEST(LaneSum, HasTheShapeOfTheSpecification) {
  const auto sum = [](int terms) {
    LaneSums<1> s;
    for (std::size_t l = 0; l < kBeamLanes; ++l) s.clear(l);
    for (int m = 0; m < terms; ++m)
      s.add(static_cast<std::size_t>(m) % kBeamLanes, {{1.0f / static_cast<float>(m + 1)}});
    return bits_of(s.fold_all().v[0]);
  };
  EXPECT_EQ(sum(360), 0x40cedee2u);
  EXPECT_EQ(sum(1000), 0x40ef88fau);
}

TEST(FieldPatch, HasTheValuesOfTheSpecification) {
  const FieldInterpolation bilinear = FieldInterpolation::bilinear, cubic = FieldInterpolation::cubic;
  const struct {
    FieldInterpolation how;
    double x_m, y_m, distance_m, slope_x, slope_y;
  } checks[] = {{bilinear, 0.8, 0.15, 0.904142135624, 0.082842712475, 0.958578643763},
                {bilinear, 1.9, 0.4, 0.438492424049, -0.824264068712, 0.589949493661},
                {bilinear, 3.0, 1.0, 0.551776695297, -0.207106781187, -0.207106781187},
                {bilinear, -0.9, -1.9, 0.0, 0.0, 0.0},
                {cubic, 0.8, 0.15, 0.934633304325, 0.100075806487, 0.835869665273},
                {cubic, 1.9, 0.4, 0.377538758362, -1.206414298746, 0.712544789844},
                {cubic, 3.0, 1.0, 0.628029879985, -0.179743302148, -0.179743302148}};
  for (const auto& c : checks) {
    const MapField t1(test::map_t1(), kNoCap_m, c.how);
    const FieldValue f = field_at(t1.field, c.x_m, c.y_m);
    EXPECT_NEAR(0.5 * f.distance, c.distance_m, kFloat) << c.x_m;
    EXPECT_NEAR(f.slope_x, c.slope_x, kFloat) << c.x_m;
    EXPECT_NEAR(f.slope_y, c.slope_y, kFloat) << c.x_m;
  }
}

TEST(FieldPatch, PullsNowhereFromTheCapOnAndOffTheMap) {
  for (const FieldInterpolation how : {FieldInterpolation::bilinear, FieldInterpolation::cubic}) {
    const MapField t1(test::map_t1(), 0.3f, how);
    for (const auto& [x_m, y_m] : {std::pair{0.8, 0.15}, {-1.01, 0.0}, {1.0, 2.01}, {1e9, 0.0}, {NAN, 0.0}}) {
      const FieldValue f = field_at(t1.field, x_m, y_m);
      EXPECT_FLOAT_EQ(f.distance, 0.6f) << x_m;
      EXPECT_EQ(f.slope_x, 0.0f);
      EXPECT_EQ(f.slope_y, 0.0f);
    }
  }
}

TEST(FieldPatch, AMapOfOneCellOrWithoutAWallIsNoTrouble) {
  for (const GridMap& map : {grid_from_text({"#"}, 0.5), grid_from_text({"..", ".."}, 0.5)}) {
    for (const FieldInterpolation how : {FieldInterpolation::bilinear, FieldInterpolation::cubic}) {
      const MapField f(map, 0.5f, how);
      const FieldValue v = look_up(f.field, {0.2f, 0.1f, 1.0f, 0.0f}, {0.0f, 0.0f});
      EXPECT_TRUE(v.distance >= 0.0f && v.distance <= 1.0f);
      EXPECT_EQ(v.slope_x, 0.0f);
      EXPECT_EQ(v.slope_y, 0.0f);
    }
  }
}

TEST(FieldMeasurement, HasTheValuesOfTheWorkedExample) {
  const MapField t1(test::map_t1(), kNoCap_m);
  const FieldMeasurement z = test::measure(t1.field, test::example_beams(), test::example_pose());
  EXPECT_EQ(z.beams, 4.0);
  EXPECT_NEAR(z.psi_m, 0.34905581136213, kFloat);
  EXPECT_NEAR(z.slope[0], 0.202075818688, kFloat);
  EXPECT_NEAR(z.slope[1], 0.134565400208, kFloat);
  EXPECT_NEAR(z.slope[2], 0.561704621380, kFloat);  // 0.5525 without the sensor's lever arm
  double sum = 0.0;
  for (const double j : {-0.154450413046, -0.245016644460, -0.245016644460, -0.137954531856}) sum += j * j;
  EXPECT_NEAR(z.range_slope_sq, sum, kFloat);
  EXPECT_NEAR(psi_variance(z, {0.02 * 0.02, 0.0}), 6.518107803001e-05, 1e-10);
}

TEST(FieldMeasurement, NoiseIsNeverZero) {
  EXPECT_GT(psi_variance(FieldMeasurement{}, {0.0, 0.0}), 0.0);
}

/// Cells at random, walls around.
GridMap random_map(std::mt19937& random) {
  std::vector<std::string> rows(50, std::string(70, '.'));
  for (auto& r : rows)
    for (char& c : r)
      if (random() % 40 == 0) c = '#';
  rows.front() = rows.back() = std::string(70, '#');
  return grid_from_text(rows, 0.1);
}

// A central difference of step h sees the patch on both sides; where it crosses a line between patches or the
// cap, the slope jumps. Such scans are told by a second difference that is not small, and left out.
TEST(FieldMeasurement, SlopesAreThoseOfTheMeanDistance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  constexpr double cap_m = 0.5, h = 1e-6;
  int compared = 0;
  for (int scene = 0; scene < 200; ++scene) {
    const GridMap map = random_map(random);
    const MapField field(map, static_cast<float>(cap_m));
    std::vector<double> bearings;
    std::vector<float> ranges;
    for (int i = 0; i < 20; ++i) {
      bearings.push_back(6.28 * unit(random));
      ranges.push_back(static_cast<float>(0.2 + 2.5 * unit(random)));
    }
    const BeamTable beams = test::beams_of({0.2, -0.1, 0.3}, bearings, ranges, map.resolution_m);
    const Vector3 pose =
        test::vector3(0.5 + 6.0 * unit(random), 0.5 + 4.0 * unit(random), 6.28 * unit(random) - 3.14);
    const FieldMeasurement z = test::measure(field.field, beams, pose);
    const auto psi = [&](int component, double by) {
      Vector3 x = pose;
      x[component] += by;
      return test::plain_psi_m(map, beams, x, cap_m);
    };
    EXPECT_NEAR(z.psi_m, psi(0, 0.0), kFloat);
    for (int c = 0; c < 3; ++c) {
      const double forward = (psi(c, h) - psi(c, 0.0)) / h, backward = (psi(c, 0.0) - psi(c, -h)) / h;
      if (std::fabs(forward - backward) > 1e-5) continue;
      ++compared;
      // float32 places an end point to 1e-5 cells here, across which a slope changes by as much.
      EXPECT_NEAR(z.slope[c], 0.5 * (forward + backward), 1e-4) << "scene " << scene << " component " << c;
    }
  }
  EXPECT_GT(compared, 500);
}

TEST(FieldMeasurement, RangeSlopesAreThoseOfTheMeanDistance) {
  const GridMap map = test::map_t1();
  const MapField t1(map, kNoCap_m);
  const std::vector<double> bearings{0.0, M_PI / 2, M_PI, -M_PI / 2};
  const std::vector<float> ranges{1.25f, 1.30f, 1.35f, 0.60f};
  constexpr float h = 0.0078125f;  // exact in float32, and no patch is crossed
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto psi = [&](float by) {
      std::vector<float> r = ranges;
      r[i] += by;
      return test::plain_psi_m(map, test::beams_of({0.1, 0, 0}, bearings, r, 0.5), test::example_pose(), 1e5);
    };
    const double j = (psi(h) - psi(-h)) / (2.0 * h);
    sum += j * j;
  }
  const FieldMeasurement z = test::measure(t1.field, test::example_beams(), test::example_pose());
  EXPECT_NEAR(z.range_slope_sq, sum, 1e-5);
}

TEST(FieldMeasurement, BeamsThatDoNotCountAddNothing) {
  const MapField t1(test::map_t1(), kNoCap_m);
  const auto scan = std::make_unique<cpu::PaddedScan>();
  const auto notes = std::make_unique<cpu::BeamNotes>();
  const BeamTable beams = test::example_beams();
  scan->set(beams);
  scan->keep[1] = 0.0f;
  const auto sum =
      cpu::sum_beams(t1.field, *scan, scan_pose(test::example_pose(), t1.field), MeanTerms{}, *notes);
  EXPECT_NEAR(0.5 * sum.v[0], 0.270104456556 + 0.324916777698 + 0.495155495467, kFloat);
}

// Three beams fit, one is far off; with a MAD of 0 nothing can be said.
TEST(FieldMeasurement, AZScoreLeavesOutWhatIsFarOff) {
  EXPECT_TRUE(is_usual(0.30f, 0.25f, 0.05f, 3.0));
  EXPECT_FALSE(is_usual(0.60f, 0.25f, 0.05f, 3.0));
  EXPECT_TRUE(is_usual(0.60f, 0.25f, 0.0f, 3.0));
}

TEST(FieldMeasurement, BeamsOutOfReachSayHowFarOffAScanIsAndPullNowhere) {
  const GridMap room = test::small_room();
  const test::MapField field(room, 0.5f);
  const std::vector<double> ahead_and_left = {0.0, M_PI / 2};
  // From (3, 1.5): the first ends 0.35 m before the wall's cells at x = 5.95; the second in the middle of the
  // room, or off the map.
  const Vector3 pose = test::vector3(3.0, 1.5, 0.0);
  for (const float far_m : {0.6f, 100.0f}) {
    const BeamTable beams = test::beams_of({0, 0, 0}, ahead_and_left, {2.6f, far_m}, room.resolution_m);
    const FieldMeasurement z = test::measure(field.field, beams, pose);
    EXPECT_NEAR(z.psi_m, (0.35 + 0.5) / 2, 1e-5);
    EXPECT_NEAR(z.pull_m, 0.35 / 2, 1e-5);
    EXPECT_NEAR(z.slope[0], -0.5, 1e-5);
    EXPECT_NEAR(z.arm_m, std::hypot(2.6, far_m) / std::sqrt(2.0), 1e-4);
    // So a filter that is sure of nothing but x goes to the wall, and not by the other beam's half metre
    // beyond it.
    const PoseGaussian prior{pose, diagonal3(1.0, 1e-9, 1e-9)};
    EXPECT_NEAR(kalman_update(prior, z, 1e-6).mean[0], 3.35, 1e-4);
  }
}

}  // namespace
}  // namespace parloc
