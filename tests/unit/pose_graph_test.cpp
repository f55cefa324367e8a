// Least squares over poses: graphs whose answer is known.
#include "common/slam/loops/pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kHalfTurn = kPi;

Matrix3 sure(double sigma_m, double sigma_rad) {
  return diagonal3(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
}

void expect_near(const Pose& a, const Pose& b, double tolerance) {
  EXPECT_NEAR(a.x_m, b.x_m, tolerance);
  EXPECT_NEAR(a.y_m, b.y_m, tolerance);
  EXPECT_NEAR(wrap64(a.theta_rad - b.theta_rad), 0.0, tolerance);
}

/// Twice round a square of 4 m in steps of 1 m; as driven.
std::vector<Pose> square() {
  std::vector<Pose> poses{{}};
  for (int k = 1; k <= 32; ++k)
    poses.push_back(compose(poses.back(), {1.0, 0.0, k % 4 == 0 ? kHalfTurn / 2 : 0.0}));
  return poses;
}

/// The chain of steps, each of them too far in the same way.
struct Drift {
  std::vector<Pose> poses{{}};
  std::vector<PoseEdge> edges;
};
Drift drifted(const std::vector<Pose>& truth, double off_m, double off_rad) {
  Drift d;
  for (std::size_t k = 1; k < truth.size(); ++k) {
    Pose step = relative(truth[k], truth[k - 1]);
    step.x_m += off_m, step.theta_rad += off_rad;
    d.edges.push_back({k - 1, k, step, sure(0.05, 0.01), false});
    d.poses.push_back(compose(d.poses.back(), step));
  }
  return d;
}
PoseEdge loop(const std::vector<Pose>& truth, std::size_t from, std::size_t to) {
  return {from, to, relative(truth[to], truth[from]), sure(0.02, 0.005), true};
}

TEST(PoseGraph, WithoutALoopNothingMoves) {
  Drift d = drifted(square(), 0.02, 0.01);
  const std::vector<Pose> before = d.poses;
  relax(d.poses, d.edges);
  for (std::size_t k = 0; k < before.size(); ++k) expect_near(d.poses[k], before[k], 1e-9);  // rounding
}

/// Three steps of 1 m, and an edge that says they make 2.4 m.
std::pair<std::vector<Pose>, std::vector<PoseEdge>> chain_and_edge(const Matrix3& edge_covariance) {
  std::vector<PoseEdge> edges;
  for (std::size_t k = 0; k < 3; ++k) edges.push_back({k, k + 1, {1, 0, 0}, sure(1, 1), false});
  edges.push_back({0, 3, {2.4, 0, 0}, edge_covariance, false});
  return {{{}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, edges};
}

// Two springs in a row: 3 m by the chain, 2.4 m by an edge as sure as each of its three steps. Of the
// missing 0.6 m each step takes 0.6 / 4, as the four are in one ring.
TEST(PoseGraph, ARingSharesWhatIsLeftOver) {
  auto [poses, edges] = chain_and_edge(sure(1, 1));
  relax(poses, edges);
  for (int k = 0; k < 4; ++k) expect_near(poses[static_cast<std::size_t>(k)], {0.85 * k, 0, 0}, 1e-6);
}

// The same, and the last edge a hundred times surer: all is left to the steps.
TEST(PoseGraph, TheSurerEdgeGivesWayLess) {
  auto [poses, edges] = chain_and_edge(sure(0.01, 0.01));
  relax(poses, edges);
  EXPECT_NEAR(poses[3].x_m, 2.4, 1e-3);
  EXPECT_NEAR(misfit_sq(poses, edges[0]), 0.04, 1e-3);
}

TEST(PoseGraph, LoopsUndoADrift) {
  const std::vector<Pose> truth = square();
  Drift d = drifted(truth, 0.02, 0.01);
  ASSERT_GT(std::fabs(d.poses[32].x_m) + std::fabs(d.poses[32].y_m), 0.5);
  for (std::size_t k = 0; k <= 16; k += 2) d.edges.push_back(loop(truth, k, k + 16));
  relax(d.poses, d.edges);
  // A round is off by 16 x 0.02 m along four sides, which cancel, and by 0.16 rad, which loops take back.
  for (std::size_t k = 0; k < truth.size(); ++k) expect_near(d.poses[k], truth[k], 0.15);
  expect_near(d.poses[32], truth[32], 0.03);
}

TEST(PoseGraph, AWrongLoopAmongRightOnesIsRefused) {
  const std::vector<Pose> truth = square();
  Drift good = drifted(truth, 0.002, 0.001);
  for (std::size_t k = 0; k <= 16; k += 2) good.edges.push_back(loop(truth, k, k + 16));
  Drift bad = good;
  PoseEdge wrong = loop(truth, 3, 25);
  wrong.step.x_m += 2.0;
  bad.edges.push_back(wrong);
  Drift believed = bad;
  believed.edges.back().may_be_wrong = false;
  relax(good.poses, good.edges);
  relax(bad.poses, bad.edges);
  relax(believed.poses, believed.edges);
  double moved_m = 0.0, believed_moved_m = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    moved_m = std::max(moved_m, std::fabs(bad.poses[k].x_m - good.poses[k].x_m));
    believed_moved_m = std::max(believed_moved_m, std::fabs(believed.poses[k].x_m - good.poses[k].x_m));
  }
  EXPECT_LT(moved_m, 0.05);  // the standard deviation of one step
  EXPECT_GT(believed_moved_m, 0.1);
  EXPECT_GT(misfit_sq(bad.poses, wrong), 100.0);
}

TEST(PoseGraph, TheFirstPoseStays) {
  const std::vector<Pose> truth = square();
  Drift d = drifted(truth, 0.02, 0.01);
  for (std::size_t k = 0; k <= 16; k += 4) d.edges.push_back(loop(truth, k, k + 16));
  relax(d.poses, d.edges);
  expect_near(d.poses[0], {}, 0.0);
}

TEST(PoseGraph, HeadingsAreComparedAcrossHalfATurn) {
  std::vector<Pose> poses{{0, 0, kHalfTurn - 0.01}, {0, 0, -kHalfTurn + 0.05}};
  relax(poses, {{0, 1, {0, 0, 0.02}, sure(1, 1), false}});
  EXPECT_NEAR(poses[1].theta_rad, -kHalfTurn + 0.01, 1e-9);
}

TEST(PoseGraph, WhatHasNoAnswerStays) {
  const std::vector<Pose> before{{}, {1, 0, 0}, {5, 5, 0}};
  std::vector<Pose> poses = before;
  relax(poses, {{0, 1, {2, 0, 0}, sure(1, 1), false}});  // nothing holds the third
  for (std::size_t k = 0; k < 3; ++k) expect_near(poses[k], before[k], 0.0);
  relax(poses, {{0, 7, {2, 0, 0}, sure(1, 1), false}});
  relax(poses, {{0, 1, {2, 0, 0}, Matrix3{}, false}});
  for (std::size_t k = 0; k < 3; ++k) expect_near(poses[k], before[k], 0.0);
  std::vector<Pose> none;
  relax(none, {});
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace parloc
