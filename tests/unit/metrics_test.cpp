#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/eval/metrics.h"
#include "common/io/log.h"
#include "tests/unit/expect.h"
#include "tests/unit/real_data.h"
#include "tests/unit/temp_file.h"

namespace parloc {
namespace {

// The worked example of SPEC 10; its values are given there to 12 decimals.
constexpr double kSpecDigits = 6e-13;
const Trajectory kTruth{
    {0, {0, 0, 0}}, {1, {1, 0, 0}}, {2, {2, 0, M_PI / 2}}, {3, {2, 1, M_PI / 2}}, {4, {2, 2, 3.1}}};
const Trajectory kEstimate{{0, {0.03, -0.04, 0.01}},
                           {1, {1, 0.1, -0.02}},
                           {2, {2.05, 0, M_PI / 2 + 0.03}},
                           {3, {2, 1.2, M_PI / 2}},
                           {4, {2.06, 2.08, -3.1}}};

TEST(CompareTracks, WorkedExample) {
  const TrackErrors e = compare_tracks(kEstimate, kTruth);
  EXPECT_EQ(e.compared, 5u);
  EXPECT_EQ(e.without_truth, 0u);
  EXPECT_NEAR(e.position_rmse_m, 0.114017542510, kSpecDigits);
  EXPECT_NEAR(e.position_mae_m, 0.1, kSpecDigits);
  EXPECT_NEAR(e.heading_rmse_rad, 0.040791654368, kSpecDigits);
  EXPECT_NEAR(e.heading_mae_rad, 0.028637061436, kSpecDigits);
  EXPECT_NEAR(e.position_max_m, 0.2, kSpecDigits);
  EXPECT_NEAR(e.heading_max_rad, 2 * M_PI - 6.2, kSpecDigits) << "across the wrap";
  // Position errors are 0.05, 0.05, 0.1, 0.1, 0.2: the 95 % quantile lies at rank 3.8 of 0 to 4.
  EXPECT_NEAR(e.position_p95_m, 0.1 + 0.8 * 0.1, kSpecDigits);
  EXPECT_NEAR(e.x_rmse_m, std::sqrt((0.03 * 0.03 + 0.05 * 0.05 + 0.06 * 0.06) / 5), kSpecDigits);
  EXPECT_NEAR(e.y_rmse_m, std::sqrt((0.04 * 0.04 + 0.1 * 0.1 + 0.2 * 0.2 + 0.08 * 0.08) / 5), kSpecDigits);
  ASSERT_EQ(e.position_error_m.size(), 5u);
  EXPECT_NEAR(e.heading_error_rad[4], 2 * M_PI - 6.2, kSpecDigits);
  EXPECT_EQ(e.stamp_s[4], 4.0);
}

TEST(CompareTracks, InterpolatesAlongTheShortestArc) {
  const Trajectory truth{{10, {0, 0, 3.0}}, {11, {1, 2, -3.0}}};
  const TrackErrors e = compare_tracks({{10.25, {0.25, 0.5, 3.0 + 0.25 * (2 * M_PI - 6.0)}}}, truth);
  ASSERT_EQ(e.compared, 1u);
  EXPECT_NEAR(e.position_max_m, 0.0, 1e-15);
  EXPECT_NEAR(e.heading_max_rad, 0.0, 1e-15);
}

TEST(CompareTracks, NoTruthOutsideOrInAGap) {
  const Trajectory truth{{0, {}}, {1.5, {}}, {4, {}}};
  const Trajectory estimate{{-0.1, {}}, {0.7, {}}, {2.0, {}}, {4.0, {}}, {4.1, {}}};
  const TrackErrors e = compare_tracks(estimate, truth);
  EXPECT_EQ(e.compared, 2u) << "within 1.5 s, and the exact last row";
  EXPECT_EQ(e.without_truth, 3u);
  EXPECT_EQ(compare_tracks(estimate, truth, 2.5).compared, 3u);
}

TEST(CompareTracks, ExactStampsWinAndTruthMayRunBackwards) {
  const Trajectory truth{{2, {2, 0, 0}}, {1, {1, 0, 0}}, {3, {3, 5, 0}}, {1.000000, {9, 9, 0}}};
  const TrackErrors e = compare_tracks({{1.0000003, {1, 0, 0}}, {1.5, {1.5, 0, 0}}, {3, {3, 5, 0}}}, truth);
  ASSERT_EQ(e.compared, 3u);
  EXPECT_EQ(e.position_error_m[0], 0.0) << "equal to 6 decimals, and the first of two rows";
  EXPECT_EQ(e.position_error_m[2], 0.0);
}

TEST(CompareTracks, NothingComparedIsNotPerfect) {
  for (const TrackErrors& e :
       {compare_tracks({}, kTruth), compare_tracks(kEstimate, {}), compare_tracks({{99, {}}}, kTruth)}) {
    EXPECT_EQ(e.compared, 0u);
    EXPECT_TRUE(std::isnan(e.position_rmse_m));
    EXPECT_TRUE(std::isnan(e.heading_max_rad));
  }
}

TEST(CompareTracks, OneNanPoseShows) {
  Trajectory estimate = kEstimate;
  estimate[2].pose.x_m = std::numeric_limits<double>::quiet_NaN();
  const TrackErrors e = compare_tracks(estimate, kTruth);
  EXPECT_TRUE(std::isnan(e.position_max_m));
  EXPECT_TRUE(std::isnan(e.position_p95_m));
  EXPECT_TRUE(std::isnan(e.x_rmse_m));
  EXPECT_NEAR(e.heading_rmse_rad, 0.040791654368, kSpecDigits);
}

TEST(CompareRelations, WorkedExample) {
  std::vector<Relation> relations;
  for (std::size_t i = 0; i + 1 < kTruth.size(); ++i) {
    relations.push_back(
        {kTruth[i].stamp_s, kTruth[i + 1].stamp_s, relative(kTruth[i + 1].pose, kTruth[i].pose)});
  }
  const RelationErrors e = compare_relations(kEstimate, relations);
  EXPECT_EQ(e.compared, 4u);
  EXPECT_NEAR(e.translation_mean_m, 0.140865608572, kSpecDigits);
  EXPECT_NEAR(e.translation_std_m, 0.038487623948, kSpecDigits);
  EXPECT_NEAR(e.rotation_mean_rad, 0.048296326795, kSpecDigits);
  EXPECT_NEAR(e.translation_rmse_m * e.translation_rmse_m, 0.021324416875, kSpecDigits);
  EXPECT_NEAR(e.translation_median_m, 0.5 * (0.133405569067 + 0.134164078650), kSpecDigits);
  EXPECT_NEAR(e.translation_max_m, 0.201445697353, kSpecDigits);
  EXPECT_NEAR(e.rotation_rmse_rad * e.rotation_rmse_rad, 0.002804948833, kSpecDigits);
  // Squared rotation 0.002804948833 in the mean: the variance is that less the squared mean.
  EXPECT_NEAR(e.rotation_std_rad, std::sqrt(0.002804948833 - 0.048296326795 * 0.048296326795), 1e-10);
  const double translation[] = {0.133405569067, 0.094447089217, 0.201445697353, 0.134164078650};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(compare_relations(kEstimate, {relations[i]}).translation_mean_m, translation[i], kSpecDigits);
    EXPECT_NEAR(e.each[i].translation_m, translation[i], kSpecDigits);
  }
}

// By hand: 3-4-5 and 5-12-13 off, turned by 0.1 and -0.3 rad; whatever the frame, and in any order of time.
TEST(CompareRelations, ByHandInAnyFrame) {
  for (const Pose& frame : {Pose{0, 0, 0}, Pose{-7, 40, 2.5}}) {
    const auto at = [&](double x_m, double y_m, double theta_rad) {
      return compose(frame, Pose{x_m, y_m, theta_rad});
    };
    const Trajectory estimate{{5, at(1.03, 0.04, 0.1)}, {3, at(0, 0, 0)}, {9, at(1.03, 0.04, 0.1)}};
    // Seen from the pose at 5 s, that at 3 s: made so that (0.05, -0.12, -0.3) is left.
    const Pose back = relative(estimate[1].pose, estimate[0].pose);
    const Relation second{5, 3, compose(back, relative({}, {0.05, -0.12, -0.3}))};
    const RelationErrors e = compare_relations(estimate, {{3, 5, {1, 0, 0}}, second, {3, 4, {}}});
    EXPECT_EQ(e.compared, 2u);
    EXPECT_EQ(e.without_pose, 1u);
    EXPECT_NEAR(e.translation_mean_m, 0.09, 1e-12);
    EXPECT_NEAR(e.translation_std_m, 0.04, 1e-12);
    EXPECT_NEAR(e.translation_median_m, 0.09, 1e-12);
    EXPECT_NEAR(e.translation_max_m, 0.13, 1e-12);
    EXPECT_NEAR(e.translation_rmse_m, std::sqrt(0.0097), 1e-12);
    EXPECT_NEAR(e.rotation_mean_rad, 0.2, 1e-12);
    EXPECT_NEAR(e.rotation_max_rad, 0.3, 1e-12);
    ASSERT_EQ(e.each.size(), 2u);
    EXPECT_EQ(e.each[1].stamp_1_s, 5.0);
    EXPECT_EQ(e.each[1].pose_2.x_m, frame.x_m);
  }
}

TEST(CompareRelations, OfARepeatedStampTheFirstCounts) {
  const Trajectory estimate{{1, {0, 0, 0}}, {2, {1, 0, 0}}, {2.0000004, {5, 0, 0}}, {1, {9, 9, 9}}};
  const RelationErrors e = compare_relations(estimate, {{1, 2, {1, 0, 0}}});
  EXPECT_EQ(e.translation_max_m, 0.0);
  EXPECT_EQ(e.repeated_stamps, 2u);
}

TEST(CompareRelations, NothingComparedIsNotPerfect) {
  const RelationErrors e = compare_relations(kEstimate, {{90, 91, {}}});
  EXPECT_EQ(e.compared, 0u);
  EXPECT_TRUE(std::isnan(e.translation_mean_m));
  EXPECT_TRUE(std::isnan(e.rotation_max_rad));
}

TEST(CompareRelations, StampsMatchToSixDecimalsOrNotAtAll) {
  const Trajectory estimate{{976052905.1673030, {}}, {976052896.7845090, {1, 0, 0}}};
  const Relation matched{976052905.1673032, 976052896.784509, {1, 0, 0}};
  const Relation other{976052905.167304, 976052896.784509, {1, 0, 0}};
  const RelationErrors e = compare_relations(estimate, {matched, other});
  EXPECT_EQ(e.compared, 1u);
  EXPECT_EQ(e.without_pose, 1u);
  EXPECT_EQ(e.translation_mean_m, 0.0);
}

TEST(Relations, ReadAndErrors) {
  const test::TempFile good("good.txt", "# c\n1.5 2.5 0.1 -0.2 0 0 0 4.0\n");
  const auto relations = read_relations(good.path());
  ASSERT_EQ(relations.size(), 1u);
  EXPECT_EQ(relations[0].stamp_1_s, 1.5);
  EXPECT_EQ(relations[0].stamp_2_s, 2.5);
  EXPECT_EQ(relations[0].delta.y_m, -0.2);
  EXPECT_NEAR(relations[0].delta.theta_rad, 4.0 - 2 * M_PI, 1e-15);
  for (const char* bad : {"1 2 3\n", "1 2 3 4 5 6 7 8 9\n", "1 2 3 4 5 6 7 nan\n"}) {
    const test::TempFile file("bad.txt", bad);
    const std::string message = error_of([&] { read_relations(file.path()); });
    EXPECT_EQ(message.rfind(file.path() + ":1: expected", 0), 0u) << message;
  }
}

TEST(Relations, AFileWithoutOneIsAnError) {
  const test::TempFile file("none.txt", "# t1 t2 dx dy dz roll pitch yaw\n\n");
  EXPECT_EQ(error_of([&] { read_relations(file.path()); }),
            file.path() + ": expected a relation, found none");
}

// ---- real data: what the data's README states about its own references --------------------------

struct Named {
  const char* folder;
  std::size_t relations;
  double mean_m, std_m, rotation_deg;
};
// The name that the list of tests shows.
void PrintTo(const Named& named, std::ostream* out) {
  *out << named.folder;
}

class RealRelations : public ::testing::TestWithParam<Named> {};
TEST_P(RealRelations, ReferenceTrajectory) {
  const Named& named = GetParam();
  const std::string folder = test::real_data(named.folder);
  PARLOC_NEEDS_FILE(folder + "/relations.txt");
  const auto relations = read_relations(folder + "/relations.txt");
  EXPECT_EQ(relations.size(), named.relations);
  const RelationErrors e = compare_relations(read_tum(folder + "/reference.tum"), relations);
  EXPECT_EQ(e.without_pose, 0u) << "stamps equal scan stamps exactly";
  // Half a unit of the last digit that the README gives.
  EXPECT_NEAR(e.translation_mean_m, named.mean_m, 6e-4);
  EXPECT_NEAR(e.translation_std_m, named.std_m, 6e-4);
  EXPECT_NEAR(e.rotation_mean_rad * 180 / M_PI, named.rotation_deg, 6e-3);
}
INSTANTIATE_TEST_SUITE_P(Logs, RealRelations,
                         ::testing::Values(Named{"intel", 2984, 0.027, 0.020, 0.98},
                                           Named{"aces", 1279, 0.045, 0.040, 0.92}),
                         [](const auto& test) { return std::string(test.param.folder); });

TEST(RealTracks, AmclOnTheHouseDrive) {
  const std::string folder = test::real_data("tb3_house");
  PARLOC_NEEDS_FILE(folder + "/amcl_recorded.tum");
  const TrackErrors e =
      compare_tracks(read_tum(folder + "/amcl_recorded.tum"), read_tum(folder + "/reference.tum"));
  // The README: mean .092 m, RMSE .104 m, max .25 m, 2.4 deg.
  EXPECT_NEAR(e.position_mae_m, 0.092, 6e-4);
  EXPECT_NEAR(e.position_rmse_m, 0.104, 6e-4);
  EXPECT_NEAR(e.position_max_m, 0.25, 6e-3);
  EXPECT_NEAR(e.heading_mae_rad * 180 / M_PI, 2.4, 0.06);
}

}  // namespace
}  // namespace parloc
