// A made-up run for the tests of reports and pictures, and a folder for what they write.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/unit/temp_file.h"
#include "tools/report/report.h"

namespace parloc::tools {

/// A hall of 20 x 10 m in 5 cm cells with walls, two pillars and an unknown margin.
inline GridMap hall() {
  GridMap map;
  map.width = 420, map.height = 220, map.resolution_m = 0.05, map.name = "hall";
  map.T_map_grid = {-0.5, -0.5, 0.0};
  map.cells.assign(420 * 220, Cell::unknown);
  for (int j = 10; j < 210; ++j) {
    for (int i = 10; i < 410; ++i) {
      const bool wall = i < 12 || i >= 408 || j < 12 || j >= 208;
      const bool pillar =
          (i > 130 && i < 150 && j > 95 && j < 125) || (i > 270 && i < 290 && j > 90 && j < 130);
      map.cells[static_cast<std::size_t>(j * 420 + i)] = wall || pillar ? Cell::occupied : Cell::free;
    }
  }
  return map;
}

/// A smooth error that a test can draw: not random, so that every run of the tests sees the same.
inline double wobble(int k, double scale) {
  return scale * (std::sin(0.7 * k) + 0.5 * std::sin(0.13 * k + 1));
}

inline Pose on_ellipse(double angle) {
  return {10 + 7 * std::cos(angle), 5 + 3.2 * std::sin(angle), angle + 1.57};
}

inline Snapshot snapshot_at(double stamp_s, const Pose& pose, double spread_m, int count) {
  Snapshot snapshot{stamp_s, pose, {}, {}};
  for (int k = 0; k < count; ++k) {
    const double r = spread_m * std::sqrt((k + 0.5) / count), turn = 2.39996 * k;  // a sunflower
    snapshot.particles.push_back({static_cast<float>(pose.x_m + r * std::cos(turn)),
                                  static_cast<float>(pose.y_m + r * std::sin(turn)),
                                  static_cast<float>(pose.theta_rad), k % 7 == 0 ? 0.01F : 1.0F});
  }
  for (int k = 0; k < 80; ++k) {
    snapshot.scan_points.push_back({static_cast<float>(0.1 + 0.25 * k), k % 2 == 0 ? 0.1F : 9.9F});
  }
  return snapshot;
}

inline void add_step(RunReport& report, int k, double stamp_s, const Pose& truth) {
  TrackErrors& e = *report.errors;
  const double ex = wobble(k, 0.01), ey = wobble(k + 40, 0.01), et = wobble(k + 9, 0.004);
  report.truth->push_back({stamp_s, truth});
  report.estimate.push_back({stamp_s, {truth.x_m + ex, truth.y_m + ey, truth.theta_rad + et}});
  const double drift = 1e-3 * std::min(k, 600);
  report.odometry.push_back({stamp_s, {truth.x_m + drift, truth.y_m - 0.6 * drift, truth.theta_rad}});
  e.stamp_s.push_back(stamp_s), e.x_error_m.push_back(ex), e.y_error_m.push_back(ey);
  e.position_error_m.push_back(std::hypot(ex, ey)), e.heading_error_rad.push_back(et);
  const double settled = 0.01 + 0.4 * std::exp(-0.2 * k);
  report.steps.push_back({stamp_s, 1000 + 700 * std::sin(0.2 * k), settled, 1.2 * settled, 0.3 * settled,
                          3 + std::abs(wobble(3 * k, 1)) + (k % 997 == 5 ? 9.0 : 0.0), k % 9 == 0, false});
}

inline RunReport sample(const GridMap* map, int steps) {
  RunReport report;
  report.title = "ellipse.log.gz on hall.yaml";
  report.command_line = "parloc run --map hall.yaml --log ellipse.log.gz --truth ellipse.tum";
  report.summary = {{"Result", "localized"}, {"Real-time factor", "31"}};
  report.details = {{"Configuration", {{"particles", "2000"}, {"sensor.model", "likelihood_field"}}},
                    {"Beams", {{"used", "48210"}, {"rejected, zero", "12"}}},
                    {"Run", {{"seed", "1"}, {"digest", std::string(64, 'a')}}}};
  report.map = map;
  report.truth.emplace();
  report.errors.emplace();
  report.resample_below = 1000, report.particles = 2000;
  for (int k = 0; k < steps; ++k) add_step(report, k, 1e9 + 0.1 * k, on_ellipse(6.0 * k / steps));
  report.errors->compared = static_cast<std::size_t>(steps);
  report.errors->position_rmse_m = 0.0123, report.errors->position_mae_m = 0.011;
  report.errors->position_p95_m = 0.02, report.errors->position_max_m = 0.024;
  report.errors->heading_rmse_rad = 0.004, report.errors->heading_mae_rad = 0.003;
  report.errors->heading_max_rad = 0.006;
  for (int k = 0; k < 8; ++k) {
    const auto at = static_cast<std::size_t>(k * (steps - 1) / 7);
    report.snapshots.push_back(snapshot_at(report.estimate[at].stamp_s, report.estimate[at].pose,
                                           0.02 + 1.5 * std::exp(-1.2 * k), 2000));
  }
  return report;
}

class ReportTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* keep = std::getenv("PARLOC_REPORT_TEST_DIR");  // to look at what the tests write
    kept_ = keep != nullptr;
    folder_ = kept_ ? std::filesystem::path(keep)
                    : std::filesystem::temp_directory_path() / ("parloc_report_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!kept_) std::filesystem::remove_all(folder_);
  }
  std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }
  std::string html(const RunReport& report, const std::string& name = "report.html") const {
    write_report(in_folder(name), report);
    return test::content_of(in_folder(name));
  }

  std::filesystem::path folder_;
  bool kept_ = false;
  GridMap map_ = hall();
};

}  // namespace parloc::tools
