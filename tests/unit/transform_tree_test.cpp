// Rigid transforms, and where frames are.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/math/portable64.h"
#include "common/ros/transform_tree.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

RigidTransform turned(double x_m, double y_m, double yaw_rad, double z_m = 0.0) {
  return {x_m, y_m, z_m, 0.0, 0.0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
}

TransformMessage said(const std::string& parent, const std::string& child, double stamp_s,
                      const RigidTransform& T) {
  TransformMessage message;
  message.header = {stamp_s, parent};
  message.child_frame = child;
  message.T_parent_child = T;
  return message;
}

TEST(RigidTransform, ComposesAndInverts) {
  const RigidTransform a = turned(1.0, 2.0, kPi / 2), b = turned(3.0, 0.0, 0.25);
  const RigidTransform ab = compose(a, b);
  expect_near(planar(ab), {1.0, 5.0, kPi / 2 + 0.25}, 1e-12, 1e-12);
  expect_near(planar(compose(ab, inverse(ab))), {}, 1e-12, 1e-12);
  const auto point = transformed(a, {1.0, 0.0, 7.0});
  EXPECT_NEAR(point[0], 1.0, 1e-12);
  EXPECT_NEAR(point[1], 3.0, 1e-12);
  EXPECT_EQ(point[2], 7.0);
}

TEST(RigidTransform, IsUnitOrNothing) {
  RigidTransform a = turned(0.0, 0.0, 1.0);
  a.qz *= 1.001;
  a.qw *= 1.001;
  EXPECT_TRUE(normalise(a));
  EXPECT_NEAR(a.qz * a.qz + a.qw * a.qw, 1.0, 1e-15);
  RigidTransform zero{0, 0, 0, 0, 0, 0, 0};
  EXPECT_FALSE(normalise(zero));
  RigidTransform infinite = turned(std::numeric_limits<double>::infinity(), 0.0, 0.0);
  EXPECT_FALSE(normalise(infinite));
}

TEST(RigidTransform, TellsHowALidarSits) {
  EXPECT_FALSE(planar_mount(turned(0.1, 0.0, kPi)).upside_down);
  // Rolled by pi about x, then turned by 0.5 about z: q = qz(0.5) * qx(pi).
  const RigidTransform rolled{0.2, 0.0, 0.3, std::cos(0.25), std::sin(0.25), 0.0, 0.0};
  const PlanarMount mount = planar_mount(rolled);
  EXPECT_TRUE(mount.upside_down);
  EXPECT_NEAR(mount.tilt_rad, 0.0, 1e-7);
  expect_near(mount.T_base_sensor, {0.2, 0.0, 0.5}, 1e-12, 1e-12);
  const double half_rad = 10.0 * kPi / 180.0 / 2.0;
  EXPECT_NEAR(planar_mount({0, 0, 0, 0.0, std::sin(half_rad), 0.0, std::cos(half_rad)}).tilt_rad,
              2 * half_rad, 1e-9);
}

TEST(TransformTree, FindsFramesBothWays) {
  TransformTree tree;
  tree.add(said("base_link", "laser", 0.0, turned(0.1, 0.0, 3.0)), true);
  tree.add(said("odom", "base_link", 5.0, turned(2.0, 1.0, 0.0)), false);
  tree.add(said("odom", "base_link", 6.0, turned(4.0, 1.0, 0.0)), false);
  const auto T_odom_laser = tree.find("odom", "laser", 5.5);
  ASSERT_TRUE(T_odom_laser);
  expect_near(planar(*T_odom_laser), {3.1, 1.0, 3.0}, 1e-12, 1e-12);
  const auto T_laser_odom = tree.find("laser", "odom", 5.5);
  ASSERT_TRUE(T_laser_odom);
  expect_near(planar(compose(*T_odom_laser, *T_laser_odom)), {}, 1e-12, 1e-12);
  EXPECT_FALSE(tree.find("map", "laser", 5.5));
  EXPECT_TRUE(tree.knows("odom"));
  EXPECT_EQ(tree.parent_of("laser"), "base_link");
  EXPECT_EQ(tree.child_on_the_way("odom", "laser"), "base_link");
}

TEST(TransformTree, OutsideItsTimesTheNearestHolds) {
  TransformTree tree;
  tree.add(said("odom", "base", 5.0, turned(2.0, 0.0, 0.0)), false);
  tree.add(said("odom", "base", 6.0, turned(4.0, 0.0, 0.0)), false);
  EXPECT_EQ(tree.find("odom", "base", 1.0)->x_m, 2.0);
  EXPECT_EQ(tree.find("odom", "base", 9.0)->x_m, 4.0);
}

TEST(TransformTree, WhatMovesCountsAndTheContradictionIsTold) {
  TransformTree tree;
  tree.add(said("base_link", "laser", 0.0, turned(0.0, 0.0, kPi)), true);
  tree.add(said("base_link", "laser", 1.0, turned(-0.1016, 0.0, kPi)), false);
  EXPECT_NEAR(tree.find("base_link", "laser", 1.0)->x_m, -0.1016, 1e-12);
  ASSERT_EQ(tree.contradictions().size(), 1u);
  EXPECT_EQ(tree.contradictions().front().frame, "laser");
  expect_parts(tree.contradictions().front().text, {"laser sits in base_link", "the second is used"});
}

TEST(TransformTree, RingsAndNonsenseEnd) {
  TransformTree tree;
  tree.add(said("a", "b", 0.0, {}), true);
  tree.add(said("b", "a", 0.0, {}), true);
  EXPECT_FALSE(tree.find("c", "a", 0.0));
  tree.add(said("a", "a", 0.0, {}), true);
  tree.add(said("", "d", 0.0, {}), true);
  tree.add(said("a", "e", 0.0, {0, 0, 0, 0, 0, 0, 0}), true);
  EXPECT_EQ(tree.refused(), 3u);
}

}  // namespace
}  // namespace parloc
