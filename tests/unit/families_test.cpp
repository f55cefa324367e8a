// Families of drives: every number stays in its range, a seed is a drive, and each trouble does what its name
// says, measured on the truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/error.h"
#include "common/eval/families/family_summary.h"
#include "common/eval/families/family_trial.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kRadPerDeg = kPi / 180.0;

const Places& places() {
  static const Places all("maps");
  return all;
}

/// The first drive of a family from `seed` on that goes through a small place: fine maps of large ones take a
/// second.
DrawnDrive small_drive_of(Family family, std::uint64_t seed = 1) {
  for (;; ++seed) {
    const DrawnDrive d = draw_drive(family, seed);
    if (place_name(d.place) != "works" && place_name(d.localized_on) != "works") return d;
  }
}

std::vector<const LogRecord*> scans_of(const TrialLog& log) {
  std::vector<const LogRecord*> scans;
  for (const LogRecord& record : log.records)
    if (record.kind == RecordKind::scan) scans.push_back(&record);
  return scans;
}

TEST(Families, AreKnownByTheirNames) {
  std::set<std::string> names;
  for (const Family family : all_families()) {
    EXPECT_EQ(family_named(name_of(family)), family);
    names.insert(name_of(family));
  }
  EXPECT_EQ(names.size(), all_families().size());
  try {
    family_named("slipz");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::usage);
    EXPECT_NE(std::string(e.what()).find("'slips'"), std::string::npos) << e.what();
  }
}

TEST(Families, EveryNumberStaysInItsRange) {
  for (const Family family : all_families())
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
      SCOPED_TRACE(testing::Message() << name_of(family) << " " << seed);
      const DrawnDrive d = draw_drive(family, seed);
      const SimulatedLidar& lidar = d.robot.lidar;
      const double hz = d.robot.scan_rate_hz, scans = d.duration_s * hz;
      EXPECT_GE(hz, family == Family::long_steps ? 0.1 : 1.0);
      EXPECT_LE(hz, 40.0);
      EXPECT_GE(d.robot.odometry.rate_hz, hz);
      EXPECT_LE(d.robot.odometry.rate_hz, 100.0);
      EXPECT_GE(lidar.range_max_m, 3.5);
      EXPECT_LE(lidar.range_max_m, 80.0);
      EXPECT_GE(d.view_rad(), 69.99 * kRadPerDeg);
      EXPECT_LE(d.view_rad(), 360.01 * kRadPerDeg);
      EXPECT_GE(lidar.beams, 90);
      EXPECT_LE(lidar.beams, 1440);
      EXPECT_GE(d.speed_mps, 0.05);
      EXPECT_LE(d.speed_mps, 7.0);
      EXPECT_GE(scans, 39.99);
      EXPECT_LE(scans, 1201.0);
      EXPECT_LE(scans * lidar.beams, 1.1 * kMostRanges + 20.0 * hz * lidar.beams);
      EXPECT_LE(d.speed_mps / hz, family == Family::long_steps ? 2.55 : 1.51);
      EXPECT_LE(std::fabs(d.start_error.x_m), 2.5 * d.start_sigma_m);
      EXPECT_LE(std::fabs(d.start_error.theta_rad), 2.5 * d.start_sigma_rad);
      EXPECT_LE(lidar.dropout_probability, family == Family::missing_returns ? 0.7 : 0.2);
      // No trouble but its own.
      const OdometryCorruption& c = d.corruption;
      EXPECT_EQ(c.slips_per_min + c.hidden_per_min > 0.0, family == Family::slips);
      EXPECT_EQ(c.offset_s != 0.0, family == Family::late_odometry);
      EXPECT_EQ(c.gyro_drift_rad_per_s != 0.0, family == Family::standing);
      EXPECT_EQ(d.clutter_share > 0.0, family == Family::clutter);
      EXPECT_EQ(d.furniture_share > 0.0, family == Family::furniture_moved);
      EXPECT_EQ(d.doors_share > 0.0, family == Family::doors);
      EXPECT_EQ(d.map_scale != 1.0, family == Family::scale);
      EXPECT_EQ(d.localized_on != d.place, family == Family::wrong_map);
      EXPECT_EQ(d.place == kCorridor, family == Family::corridor);
      for (const auto& [name, value] : parameters_of(d)) EXPECT_TRUE(std::isfinite(value)) << name;
    }
}

TEST(Families, EachStaysInItsPart) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    EXPECT_LE(draw_drive(Family::slow_scans, seed).robot.scan_rate_hz, 2.001);
    EXPECT_LE(draw_drive(Family::short_range, seed).robot.lidar.range_max_m, 5.0);
    EXPECT_LE(draw_drive(Family::narrow_view, seed).view_rad(), 120.01 * kRadPerDeg);
    EXPECT_GE(draw_drive(Family::missing_returns, seed).robot.lidar.dropout_probability, 0.3);
    EXPECT_GE(draw_drive(Family::fast, seed).speed_mps, 2.5);
    const DrawnDrive steps = draw_drive(Family::long_steps, seed);
    EXPECT_GE(steps.speed_mps / steps.robot.scan_rate_hz, 0.95);
    EXPECT_LE(steps.speed_mps / steps.robot.scan_rate_hz, 2.55);
    const DrawnDrive standing = draw_drive(Family::standing, seed);
    EXPECT_GE(standing.stand_s, 119.0);
    EXPECT_GE(std::fabs(standing.corruption.gyro_drift_rad_per_s), 0.00099 * kRadPerDeg);
    EXPECT_LE(std::fabs(standing.corruption.gyro_drift_rad_per_s), 0.02001 * kRadPerDeg);
    const DrawnDrive slips = draw_drive(Family::slips, seed);
    EXPECT_LE(slips.corruption.most_slip_rad, 40.0 * kRadPerDeg);
    EXPECT_GE(slips.corruption.least_slip_m, 0.1);
    EXPECT_LE(slips.corruption.slips_per_min + slips.corruption.hidden_per_min, 6.0);
    EXPECT_GE(slips.corruption.slips_per_min + slips.corruption.hidden_per_min, 1.0);
    const DrawnDrive corridor = draw_drive(Family::corridor, seed);
    EXPECT_LE(corridor.corridor_start_m + corridor.speed_mps * corridor.duration_s +
                  corridor.robot.lidar.range_max_m,
              kCorridorLength_m + 0.1);
  }
}

TEST(Families, PlacesAreAsLargeAsTheDrawsTakeThemToBe) {
  for (std::size_t k = 0; k < kPlaces.size(); ++k)
    EXPECT_NEAR(std::sqrt(places().at(k).area->area_m2()), kPlaces[k].side_m, 0.6) << place_name(k);
}

TEST(Families, PlacesNeedTheirMaps) {
  EXPECT_THROW(Places("maps/fine/nowhere"), Error);
}

// The whole of a range is used, and every place.
TEST(Families, FillTheirRanges) {
  double least_hz = 100.0, most_hz = 0.0, least_speed = 100.0, most_speed = 0.0, all_around = 0.0;
  std::set<std::size_t> seen;
  constexpr int kSeeds = 1000;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const DrawnDrive d = draw_drive(Family::plain, seed);
    least_hz = std::min(least_hz, d.robot.scan_rate_hz), most_hz = std::max(most_hz, d.robot.scan_rate_hz);
    least_speed = std::min(least_speed, d.speed_mps), most_speed = std::max(most_speed, d.speed_mps);
    all_around += d.view_rad() > 359.9 * kRadPerDeg ? 1.0 / kSeeds : 0.0;
    seen.insert(d.place);
  }
  EXPECT_LT(least_hz, 1.1);
  EXPECT_EQ(most_hz, 40.0);
  EXPECT_LT(least_speed, 0.06);
  EXPECT_GT(most_speed, 5.0);
  EXPECT_NEAR(all_around, 0.2, 0.04);
  EXPECT_EQ(seen.size(), kPlaces.size());
}

TEST(Families, ASeedIsADriveAndSeedsDiffer) {
  for (const Family family : {Family::slips, Family::furniture_moved, Family::kidnapped}) {
    const DrawnDrive d = small_drive_of(family);
    const FamilyTrial a = make_trial(d, places()), b = make_trial(draw_drive(family, d.seed), places());
    ASSERT_EQ(a.log.records.size(), b.log.records.size());
    for (std::size_t k = 0; k < a.log.records.size(); ++k) {
      EXPECT_EQ(a.log.records[k].odometry.x_m, b.log.records[k].odometry.x_m);
      EXPECT_EQ(a.log.records[k].odometry.theta_rad, b.log.records[k].odometry.theta_rad);
      const auto &p = a.log.records[k].scan.ranges_m, &q = b.log.records[k].scan.ranges_m;
      ASSERT_TRUE(std::equal(p.begin(), p.end(), q.begin(), q.end(),
                             [](float x, float y) { return x == y || (x != x && y != y); }));
    }
    const DrawnDrive other = small_drive_of(family, d.seed + 1);
    EXPECT_NE(d.robot.lidar.range_max_m, other.robot.lidar.range_max_m);
  }
}

TEST(Families, EveryOneCanBeMade) {
  for (const Family family : all_families()) {
    SCOPED_TRACE(name_of(family));
    const DrawnDrive d = small_drive_of(family, 3);
    const FamilyTrial trial = make_trial(d, places());
    const auto scans = scans_of(trial.log);
    EXPECT_GE(scans.size(), 38u);  // a kidnapping may cost one at the end of each half
    EXPECT_EQ(scans.size(), trial.log.truth.size());
    EXPECT_LE(trial.log.truth.back().stamp_s, d.duration_s + 2.0 / d.robot.scan_rate_hz);
    ASSERT_TRUE(trial.log.start);
    EXPECT_TRUE(trial.map);
  }
}

TEST(Families, ClutterIsTheShareThatWasDrawn) {
  double off = 0.0;
  constexpr int kDrives = 8;
  std::uint64_t seed = 1;
  for (int k = 0; k < kDrives; ++k) {
    const DrawnDrive d = small_drive_of(Family::clutter, seed);
    seed = d.seed + 1;
    const FamilyTrial trial = make_trial(d, places());
    const double share = static_cast<double>(trial.log.unmapped) / static_cast<double>(trial.log.hits);
    EXPECT_NEAR(share, d.clutter_share, 0.12) << d.seed;  // the view of a single person may be a tenth
    off += (share - d.clutter_share) / kDrives;
  }
  EXPECT_NEAR(off, 0.0, 0.05);
}

// A map that is too large by 1 % makes the truth, in its coordinates, go 1 % further than the robot does.
TEST(Families, AMapOfTheWrongScale) {
  DrawnDrive d = small_drive_of(Family::scale);
  d.robot.odometry.scale_translation = 1.0;
  d.robot.odometry.errors = OdometryErrors::wheels;
  d.robot.odometry.kappa_m = 0.0;
  d.speed_mps = 0.5;
  const FamilyTrial trial = make_trial(d, places());
  double truth_m = 0.0, odometry_m = 0.0;
  const auto scans = scans_of(trial.log);
  for (std::size_t k = 1; k < scans.size(); ++k) {
    truth_m += distance_m(trial.log.truth[k].pose, trial.log.truth[k - 1].pose);
    odometry_m += distance_m(scans[k]->odometry, scans[k - 1]->odometry);
  }
  EXPECT_NEAR(truth_m / odometry_m, d.map_scale, 2e-3);  // chords of turns
  EXPECT_NEAR(std::fabs(d.map_scale - 1.0), 0.01, 1e-12);
}

TEST(Families, LateOdometryIsLateAgainstTheTruth) {
  DrawnDrive d = small_drive_of(Family::late_odometry);
  for (std::uint64_t seed = 1; d.robot.scan_rate_hz > 5.0; ++seed)
    d = small_drive_of(Family::late_odometry, seed);
  d.corruption.offset_s = 0.15;
  d.robot.odometry.kappa_m = 0.0, d.robot.odometry.errors = OdometryErrors::wheels;
  d.robot.odometry.scale_translation = d.robot.odometry.scale_rotation = 1.0;
  d.robot.odometry.drift_rad_per_m = 0.0;
  const FamilyTrial late = make_trial(d, places());
  d.corruption.offset_s = 0.0;
  const FamilyTrial exact = make_trial(d, places());
  const auto scans = scans_of(late.log), on_time = scans_of(exact.log);
  std::size_t straight = 0;
  for (std::size_t k = 1; k + 1 < scans.size(); ++k) {
    const Pose before = on_time[k - 1]->odometry, now = on_time[k]->odometry;
    const double step_m = distance_m(now, before), dt_s = on_time[k]->stamp_s - on_time[k - 1]->stamp_s;
    if (turn_rad(now, before) > 1e-9 || std::fabs(step_m - d.speed_mps * dt_s) > 1e-6 || dt_s < 0.15)
      continue;
    ++straight;
    EXPECT_NEAR(distance_m(scans[k]->odometry, now), 0.15 * d.speed_mps, 1e-3);
  }
  EXPECT_GT(straight, 3u);
}

TEST(Families, AStandingRobotStandsWhileItsHeadingDrifts) {
  const DrawnDrive d = small_drive_of(Family::standing);
  const FamilyTrial trial = make_trial(d, places());
  const auto scans = scans_of(trial.log);
  std::size_t last = 0;
  while (last + 1 < scans.size() && scans[last + 1]->stamp_s <= d.stand_s) ++last;
  EXPECT_EQ(distance_m(trial.log.truth[0].pose, trial.log.truth[last].pose), 0.0);
  const double drift_rad = wrap64(scans[last]->odometry.theta_rad - scans[0]->odometry.theta_rad);
  EXPECT_NEAR(drift_rad, d.corruption.gyro_drift_rad_per_s * scans[last]->stamp_s, 1e-6);
  EXPECT_GT(distance_m(trial.log.truth[0].pose, trial.log.truth.back().pose) +
                turn_rad(trial.log.truth[0].pose, trial.log.truth.back().pose),
            0.05);
}

TEST(Families, ACarriedRobotIsElsewhereAndItsOdometryDoesNotKnow) {
  const DrawnDrive d = small_drive_of(Family::kidnapped);
  const FamilyTrial trial = make_trial(d, places());
  const auto scans = scans_of(trial.log);
  std::size_t at = 0;
  while (scans[at]->stamp_s < trial.log.kidnapped_s) ++at;
  EXPECT_LT(distance_m(scans[at]->odometry, scans[at - 1]->odometry), 1.6);
  EXPECT_GT(distance_m(trial.log.truth[at].pose, trial.log.truth[at - 1].pose), 1.6);
  EXPECT_NEAR(trial.log.kidnapped_s, 0.5 * d.duration_s, 2.0 / d.robot.scan_rate_hz);
}

TEST(Families, OnAWrongMapNoPoseIsRight) {
  const DrawnDrive d = small_drive_of(Family::wrong_map);
  const FamilyTrial trial = make_trial(d, places());
  EXPECT_TRUE(trial.log.elsewhere);
  EXPECT_EQ(trial.map, places().at(d.localized_on).map);
  EXPECT_EQ(trial.map->at_point(trial.log.start->pose.x_m - 0.0, trial.log.start->pose.y_m), Cell::free);
  LocalizerConfig config;
  config.particles = 200, config.threads = 1, config.localize.recover = false;
  Localizer localizer(config, *trial.map);
  const auto result = run_trial(localizer, trial.plan, trial.log, 1);
  const RunScore score = score_run(*result);
  EXPECT_EQ(score.within, 0.0);
  EXPECT_TRUE(std::isinf(score.largest_m));
  EXPECT_EQ(result->outcome.right, 0u);
}

TEST(Families, AStartIsSaidWithItsError) {
  const DrawnDrive d = small_drive_of(Family::plain);
  const FamilyTrial trial = make_trial(d, places());
  const Pose error = relative(trial.log.start->pose, trial.log.truth.front().pose);
  EXPECT_NEAR(error.x_m, d.start_error.x_m, 1e-9);
  EXPECT_NEAR(error.theta_rad, d.start_error.theta_rad, 1e-9);
  EXPECT_EQ(trial.log.start->sigma_xy_m, d.start_sigma_m);
}

RunScore score_of(double rmse_m, double largest_m) {
  RunScore s;
  s.samples = 10;
  s.rmse_m = rmse_m, s.largest_m = largest_m;
  return s;
}

TEST(CompareRuns, HoldsTheLoopToTheBareFilter) {
  EXPECT_TRUE(compare_runs(score_of(0.11, 0.3), score_of(0.1, 0.2)).kept);
  EXPECT_FALSE(compare_runs(score_of(0.12, 0.2), score_of(0.1, 0.2)).kept);
  EXPECT_FALSE(compare_runs(score_of(0.1, 0.31), score_of(0.1, 0.2)).kept);
  EXPECT_TRUE(compare_runs(score_of(0.12, 0.2), score_of(0.1, 0.2)).applies);
  EXPECT_FALSE(compare_runs(score_of(0.1, 0.2), score_of(0.2, 0.6)).applies);
  EXPECT_FALSE(compare_runs({}, {}).applies);
}

TrialSample sample(double stamp_s, double error_m, HealthState state, double probability) {
  TrialSample s;
  s.stamp_s = stamp_s, s.position_error_m = error_m, s.state = state, s.probability = probability,
  s.nees = 3.0;
  return s;
}

TEST(ScoreRun, CountsWhatHappened) {
  TrialResult trial;
  trial.begun_s = 0.0;
  trial.samples = {sample(0, 0.3, HealthState::tracking, 0.9), sample(5, 0.4, HealthState::ambiguous, 0.5),
                   sample(12, 2.0, HealthState::tracking, 0.9), sample(13, 0.1, HealthState::lost, 0.1)};
  trial.outcome = judge_trial({.task = TrialTask::track}, trial.samples, 0.0);
  const RunScore score = score_run(trial);
  EXPECT_EQ(score.within, 0.75);
  EXPECT_EQ(score.largest_m, 2.0);
  EXPECT_NEAR(score.rmse_m, std::sqrt((0.09 + 0.16 + 4.0 + 0.01) / 4.0), 1e-12);
  EXPECT_EQ(score.by_state[static_cast<std::size_t>(HealthState::tracking)], 0.5);
  EXPECT_EQ(score.sure_wrong_s, 1.0);
  EXPECT_EQ(score.late, 2u);
  EXPECT_EQ(score.late_sure_wrong, 1u);
}

TEST(SummariseFamilies, GroupsCountsAndNamesTheFailed) {
  std::vector<DriveResult> drives(3);
  for (std::size_t k = 0; k < 3; ++k) {
    DriveResult& d = drives[k];
    d.family = k < 2 ? "slips" : "plain";
    d.seed = 10 + k;
    d.driven_s = 10.0;
    d.closed.samples = d.bare.samples = {sample(0, 0.1, HealthState::tracking, 0.85),
                                         sample(10, 0.1, HealthState::tracking, 0.85)};
    if (k == 1) d.closed.samples[1].position_error_m = 3.0;
    d.closed.marks = marks_of({}, d.closed.samples), d.bare.marks = marks_of({}, d.bare.samples);
    d.closed.outcome = judge_trial({}, d.closed.samples, 0.0);
    d.bare.outcome = judge_trial({}, d.bare.samples, 0.0);
    d.closed_score = score_run(d.closed), d.bare_score = score_run(d.bare);
    d.comparison = compare_runs(d.closed_score, d.bare_score);
  }
  const FamilySummaries summaries = summarise_families(drives);
  const std::vector<FamilySummary>& families = summaries.families;
  ASSERT_EQ(families.size(), 2u);
  EXPECT_EQ(families[0].family, "slips");
  EXPECT_EQ(families[0].kept.trials, 2u);
  EXPECT_EQ(families[0].kept.hits, 1u);
  EXPECT_EQ(families[0].failed, std::vector<std::uint64_t>{11});
  EXPECT_EQ(families[1].kept.hits, 1u);
  EXPECT_NEAR(families[0].closed.calibration_error, 0.1, 1e-5);  // 0.85 said, 3 of 4 right
  EXPECT_EQ(families[0].closed.nearly_all_within.hits, 1u);
  EXPECT_EQ(families[0].bare.nearly_all_within.hits, 2u);
  EXPECT_EQ(families[0].bare.nees_median, 3.0);
  const FamilySummary& all = summaries.all;
  EXPECT_EQ(all.drives, 3u);
  EXPECT_EQ(all.kept.hits, 2u);
}

}  // namespace
}  // namespace parloc
