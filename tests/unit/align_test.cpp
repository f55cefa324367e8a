// Laying a trajectory on another: known transforms, and that no other transform fits better.
#include "common/eval/align.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/expect.h"

namespace parloc {
namespace {

/// A bent path, a pose every half second.
Trajectory bent_path() {
  Trajectory t;
  for (int k = 0; k < 60; ++k)
    t.push_back({0.5 * k, {0.2 * k, 3.0 * std::sin(0.1 * k), std::atan(1.5 * std::cos(0.1 * k))}});
  return t;
}

double squares(const Trajectory& a, const Trajectory& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k)
    sum += std::pow(a[k].pose.x_m - b[k].pose.x_m, 2) + std::pow(a[k].pose.y_m - b[k].pose.y_m, 2);
  return sum;
}

TEST(BestAlignment, UndoesARigidTransform) {
  for (const Pose& T : {Pose{0, 0, 0}, Pose{5, -70, 3.0}, Pose{-1e3, 2, -1.6}}) {
    const auto found = best_alignment(transformed(T, bent_path()), bent_path());
    ASSERT_TRUE(found);
    expect_near(*found, T, 1e-9, 1e-11);  // 1e3 m have 1e-13 of themselves
  }
}

TEST(BestAlignment, NoOtherTransformFitsBetter) {
  Trajectory estimate = bent_path();
  for (std::size_t k = 0; k < estimate.size(); ++k)  // bent, so that nothing fits exactly
    estimate[k].pose.x_m += 0.02 * static_cast<double>(k % 7), estimate[k].pose.y_m += 1e-4 * k * k;
  const auto best = best_alignment(estimate, bent_path());
  ASSERT_TRUE(best);
  const double least = squares(estimate, transformed(*best, bent_path()));
  EXPECT_GT(least, 0.01);
  constexpr double kStep = 1e-3;
  for (const Pose& d : {Pose{kStep, 0, 0}, Pose{-kStep, 0, 0}, Pose{0, kStep, 0}, Pose{0, -kStep, 0},
                        Pose{0, 0, kStep}, Pose{0, 0, -kStep}})
    EXPECT_GT(squares(estimate, transformed(compose(*best, d), bent_path())), least);
}

TEST(BestAlignment, NeedsTwoPlaces) {
  EXPECT_FALSE(best_alignment({}, bent_path()));
  Trajectory later = bent_path();
  for (StampedPose& p : later) p.stamp_s += 1000.0;  // no truth then
  EXPECT_FALSE(best_alignment(later, bent_path()));
  EXPECT_FALSE(best_alignment({{1.0, {1, 2, 0}}}, bent_path()));
  EXPECT_FALSE(best_alignment({{1.0, {1, 2, 0}}, {2.0, {1, 2, 0.5}}}, bent_path()));  // turned on the spot
}

}  // namespace
}  // namespace parloc
