// Rays against walls that are segments: known answers, and the search by cells against trying every wall.
#include "common/map/rays/wall_cast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/error.h"
#include "common/filter/bind.h"
#include "common/map/rays/skip_field.h"
#include "common/map/rays/wall_index.h"
#include "common/math/portable.h"

namespace parloc {
namespace {

constexpr float kPi = 3.14159265f;

Ray ray_at(float u, float v, float angle_rad) {
  const SinCos h = portable_sincos(angle_rad);
  return beam_ray(u, v, h.cos, h.sin, 1.0f, 0.0f);
}

RayWall wall(float ax, float ay, float bx, float by) {
  return {ax, ay, bx - ax, by - ay};
}

constexpr float kDegree = kPi / 180.0f;

TEST(WallHit, KnownAnswers) {  // SPEC 2.4
  EXPECT_FLOAT_EQ(wall_hit(ray_at(0, 0, 30 * kDegree), wall(2, -1, 2, 3)), 2.309401077f);
  EXPECT_FLOAT_EQ(wall_hit(ray_at(0, 0, 45 * kDegree), wall(1, 1, 2, 0)), 1.414213562f);
  EXPECT_FLOAT_EQ(wall_hit(ray_at(0, 0, 90 * kDegree), wall(-1, 2, 0, 2)), 2.0f);
  EXPECT_EQ(wall_hit(ray_at(0, 0, -kPi), wall(1, 0, 3, 0)), kNoWall);
}

TEST(WallHit, ARayAlongAWallHitsItsNearerEnd) {
  EXPECT_EQ(wall_hit(ray_at(0, 0, 0), wall(1, 0, 3, 0)), 1.0f);
  EXPECT_EQ(wall_hit(ray_at(0, 0, 0), wall(3, 0, 1, 0)), 1.0f);
  EXPECT_EQ(wall_hit(ray_at(2, 0, 0), wall(1, 0, 3, 0)), 0.0f) << "within";
  EXPECT_EQ(wall_hit(ray_at(4, 0, 0), wall(1, 0, 3, 0)), kNoWall) << "behind";
  EXPECT_EQ(wall_hit(ray_at(0, 0.1f, 0), wall(1, 0, 3, 0)), kNoWall) << "beside";
}

TEST(WallHit, AWallThatIsTouchedAtItsEndsOrAtTheStartIsHit) {
  EXPECT_FLOAT_EQ(wall_hit(ray_at(0, 0, 0), wall(2, 0, 2, 5)), 2.0f);
  EXPECT_FLOAT_EQ(wall_hit(ray_at(0, 0, 0), wall(2, -5, 2, 0)), 2.0f);
  EXPECT_EQ(wall_hit(ray_at(0, 0, 0), wall(0, -1, 0, 1)), 0.0f);
  EXPECT_EQ(wall_hit(ray_at(0, 0, 0), wall(2, 0.01f, 2, 5)), kNoWall);
}

// The hit is as far as float64 says, or the ray passes an end of the wall within the slack.
TEST(WallHit, AgreesWithFloat64) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-200.0f, 200.0f), angle(-kPi, kPi);
  int hits = 0;
  for (int k = 0; k < 200000; ++k) {
    const Ray r = ray_at(place(random), place(random), angle(random));
    const RayWall w = wall(place(random), place(random), place(random), place(random));
    const double dx = r.dx, dy = r.dy, x = double{w.ax} - r.u, y = double{w.ay} - r.v;
    const double det = dx * w.ey - dy * w.ex, share = (x * dy - y * dx) / det;
    const double t = (x * w.ey - y * w.ex) / det;
    const double near_end = std::min(std::fabs(share), std::fabs(share - 1)) * std::fabs(det);
    if (std::fabs(det) < 0.1 || near_end < 1e-3 || std::fabs(t) < 1e-2) continue;
    const bool hit = share > 0 && share < 1 && t > 0;
    hits += hit ? 1 : 0;
    const float got = wall_hit(r, w);
    ASSERT_EQ(got != kNoWall, hit) << k;
    // Rounding of `off`, 6e-8 of 400 cells and more, over the sine of the angle between ray and wall.
    const double sine = std::fabs(det) / std::hypot(double{w.ex}, double{w.ey});
    if (hit) {
      ASSERT_NEAR(got, t, 2e-4 / sine) << k;
    }
  }
  EXPECT_GT(hits, 10000);
}

/// `count` walls of all lengths in a grid of 300 x 200 cells of 0.1 m; many share ends, some come twice, some
/// are parallel to the axes and on grid lines.
GridMap random_walls(std::uint32_t seed, std::size_t count) {
  GridMap map;
  map.width = 300, map.height = 200, map.resolution_m = 0.1;
  map.cells.assign(300 * 200, Cell::free);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> x(1.0f, 29.0f), y(1.0f, 19.0f), step(-2.0f, 2.0f);
  float ax = x(random), ay = y(random);
  for (std::size_t k = 0; k < count; ++k) {
    const bool jump = random() % 4 == 0;
    float bx = jump ? x(random) : std::clamp(ax + step(random), 1.0f, 29.0f);
    float by = jump ? y(random) : std::clamp(ay + step(random), 1.0f, 19.0f);
    if (random() % 3 == 0) bx = ax;
    if (random() % 8 == 0) ax = bx = std::round(ax), by = std::round(by);
    map.walls.push_back({ax, ay, bx, by});
    if (random() % 10 == 0) map.walls.push_back(map.walls.back());
    ax = bx, ay = by;
    if (jump) ax = x(random), ay = y(random);
  }
  return map;
}

struct Indexed {
  explicit Indexed(const GridMap& map)
      : index(index_walls(map)),
        skip(skip_field(index.blocks.data(), map.width, map.height, 16 << 20)),
        ray_map(bind_ray_map(skip.lines.data(), skip.planes, map, index.view())) {}
  WallIndex index;
  SkipField skip;
  RayMap ray_map;
};

TEST(CastWalls, FindsWhatTryingEveryWallFinds) {
  for (const std::size_t count : {1u, 7u, 64u, 1000u}) {
    const GridMap map = random_walls(static_cast<std::uint32_t>(count), count);
    const Indexed at(map);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> u(-5.0f, 305.0f), v(-5.0f, 205.0f), angle(-kPi, kPi);
    int hits = 0;
    for (int k = 0; k < 60000; ++k) {
      float start_u = u(random), start_v = v(random), heading = angle(random);
      if (k % 5 == 0) start_u = std::round(start_u);
      if (k % 7 == 0) start_v = std::round(start_v);
      if (k % 11 == 0) heading = static_cast<float>(k % 8) * kPi / 4;
      Ray r = ray_at(start_u, start_v, heading);
      if (k % 3 == 0) {  // at an end of a wall, or along it
        const RayWall& w = at.index.walls[random() % at.index.walls.size()];
        const float dx = w.ax - start_u, dy = w.ay - start_v, length = std::hypot(dx, dy);
        if (length > 0) r = make_ray(start_u, start_v, dx / length, dy / length);
        const float own = std::hypot(w.ex, w.ey);
        if (k % 2 == 0 && own > 0)
          r = make_ray(w.ax - 3 * w.ex / own, w.ay - 3 * w.ey / own, w.ex / own, w.ey / own);
      }
      const float reach = k % 2 == 0 ? 80.0f : 1000.0f;
      const float nearest = cast_walls(at.ray_map, r, reach), every = cast_all_walls(at.ray_map, r, reach);
      ASSERT_EQ(nearest, every) << count << " walls, ray " << k;
      hits += every != kNoWall ? 1 : 0;
    }
    EXPECT_GT(hits, 500);
  }
}

TEST(CastWalls, NoRaySlipsThroughACornerOfAClosedRoom) {
  GridMap map;
  map.width = map.height = 400, map.resolution_m = 0.05;
  map.cells.assign(400 * 400, Cell::free);
  const int corners = 37;
  const auto corner = [&](int k) {
    const double a = 2 * 3.141592653589793 * k / corners;
    return std::pair(static_cast<float>(10 + 9 * std::cos(a)), static_cast<float>(10 + 9 * std::sin(a)));
  };
  for (int k = 0; k < corners; ++k)
    map.walls.push_back({corner(k).first, corner(k).second, corner(k + 1).first, corner(k + 1).second});
  const Indexed at(map);
  std::mt19937 random(9);
  std::uniform_real_distribution<float> inside(140.0f, 260.0f);
  for (int k = 0; k < 200000; ++k) {
    const float u = inside(random), v = inside(random);
    const RayWall& w = at.index.walls[random() % at.index.walls.size()];
    const float length = std::hypot(w.ax - u, w.ay - v);
    const Ray r = make_ray(u, v, (w.ax - u) / length, (w.ay - v) / length);
    ASSERT_NEAR(cast_walls(at.ray_map, r, 1000.0f), length, 1e-3f) << k;
  }
}

TEST(IndexWalls, ListsEveryWallInTheCellsOfItsPoints) {
  const GridMap map = random_walls(1, 300);
  const WallIndex index = index_walls(map);
  for (std::size_t k = 0; k < index.walls.size(); ++k) {
    const RayWall& w = index.walls[k];
    for (int s = 0; s <= 1000; ++s) {
      const float share = static_cast<float>(s) / 1000.0f;
      const int i = std::min(static_cast<int>(w.ax + share * w.ex), map.width - 1);
      const int j = std::min(static_cast<int>(w.ay + share * w.ey), map.height - 1);
      const std::size_t cell = static_cast<std::size_t>(j * map.width + i);
      const auto begin = index.ids.begin() + index.first[cell],
                 end = index.ids.begin() + index.first[cell + 1];
      ASSERT_NE(std::find(begin, end, k), end) << "wall " << k << " at " << share;
      ASSERT_EQ(index.blocks[cell], 1);
    }
  }
}

TEST(IndexWalls, AWallOutsideTheGridIsAnError) {
  GridMap map = random_walls(1, 3);
  map.walls.push_back({1.0f, 1.0f, 29.95f, 1.0f});
  EXPECT_THROW(index_walls(map), Error);
}

}  // namespace
}  // namespace parloc
