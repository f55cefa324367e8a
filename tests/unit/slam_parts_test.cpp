// The parts of grid SLAM against known answers and slow references.
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "common/slam/gaussian_proposal.h"
#include "common/slam/matching/draw.h"
#include "common/slam/matching/hill_climb.h"
#include "common/slam/path_tree.h"

namespace parloc {
namespace {

// ---- Cells ------------------------------------------------------------------------------------------------

TEST(SlamCell, CountsBeamsAndWhereTheyEnded) {
  CellWord w = 0;
  for (int k = 0; k < 7; ++k) w += kPassed;
  w += ended_at(0.25f, 0.75f);
  w += ended_at(0.75f, 0.25f);
  EXPECT_EQ(visits_of(w), 9u);
  EXPECT_EQ(hits_of(w), 2u);
  const MeanPlace mean = mean_place(w);
  EXPECT_NEAR(mean.x, 0.5, 0.5 / kPlacesPerCell);
  EXPECT_NEAR(mean.y, 0.5, 0.5 / kPlacesPerCell);
}

TEST(SlamCell, IsAWallFromATenthOfTheBeamsOn) {
  EXPECT_FALSE(is_occupied(0));
  EXPECT_FALSE(is_occupied(cell_word(10, 1, 0, 0)));
  EXPECT_TRUE(is_occupied(cell_word(9, 1, 0, 0)));
}

TEST(SlamCell, AgesBeforeAnyFieldRunsOver) {
  CellWord w = 0;
  for (int scan = 0; scan < 50; ++scan) {
    for (std::size_t k = 0; k < kMostDrawnBeams; ++k) w += ended_at(0.999f, 0.999f);
    EXPECT_EQ(visits_of(w), hits_of(w));  // a field that ran over would spoil the next one
    w = aged(w);
    EXPECT_LT(hits_of(w), kMostHits);
    EXPECT_GT(mean_place(w).x, 0.98f);
    EXPECT_GT(mean_place(w).y, 0.98f);
  }
  CellWord passed = 0;
  for (int scan = 0; scan < 100; ++scan) {
    for (std::size_t k = 0; k < kMostDrawnBeams; ++k) passed += kPassed;
    EXPECT_EQ(hits_of(passed), 0u);
    passed = aged(passed);
  }
}

// ---- The cells that a beam passes -------------------------------------------------------------------------

std::pair<int, int> cell_at(double u, double v) {
  return {static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v))};
}

/// Cells by many small steps in float64; those that a step may have jumped over at a corner are missing.
std::set<std::pair<int, int>> cells_by_steps(const DrawnBeam& b) {
  std::set<std::pair<int, int>> cells;
  constexpr int kSteps = 20000;
  for (int k = 0; k <= kSteps; ++k) {
    const double t = static_cast<double>(k) / kSteps;
    cells.insert(cell_at(b.u0 + t * (double{b.u1} - b.u0), b.v0 + t * (double{b.v1} - b.v0)));
  }
  return cells;
}

/// Numbers from 0 to 1, the same everywhere.
struct Random {
  std::uint32_t state;
  float operator()() { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f; }
};

TEST(CellWalk, PassesTheCellsBetweenItsEnds) {
  Random random{1};
  for (int k = 0; k < 300; ++k) {
    const DrawnBeam b{40.0f * random() - 20.0f, 40.0f * random() - 20.0f, 40.0f * random() - 20.0f,
                      40.0f * random() - 20.0f, true};
    std::vector<std::pair<int, int>> walked;
    int ends = 0;
    walk_beam(b, [&](std::int32_t i, std::int32_t j, bool last) {
      walked.push_back({i, j});
      ends += last ? 1 : 0;
    });
    ASSERT_EQ(ends, 1);
    EXPECT_EQ(walked.front(), cell_at(b.u0, b.v0));
    EXPECT_EQ(walked.back(), cell_at(b.u1, b.v1));
    for (std::size_t n = 1; n < walked.size(); ++n) {
      const auto &here = walked[n], &before = walked[n - 1];
      EXPECT_EQ(std::abs(here.first - before.first) + std::abs(here.second - before.second), 1);
    }
    const std::set<std::pair<int, int>> seen(walked.begin(), walked.end());
    for (const auto& cell : cells_by_steps(b))
      EXPECT_TRUE(seen.count(cell)) << cell.first << " " << cell.second;
  }
}

TEST(CellWalk, StaysInOneCellOrOnOneLine) {
  int cells = 0;
  walk_beam({0.2f, 0.2f, 0.9f, 0.7f, true}, [&](std::int32_t, std::int32_t, bool) { ++cells; });
  EXPECT_EQ(cells, 1);
  cells = 0;
  walk_beam({0.5f, 0.5f, -6.5f, 0.5f, true}, [&](std::int32_t, std::int32_t j, bool) {
    ++cells;
    EXPECT_EQ(j, 0);
  });
  EXPECT_EQ(cells, 8);
}

// ---- Matching ---------------------------------------------------------------------------------------------

/// A map of 4 x 4 tiles around the origin.
class MatchBeam : public testing::Test {
 protected:
  MatchBeam() : chunk_(kChunkTiles), table_(16) {
    for (std::uint32_t k = 0; k < 16; ++k) table_[k] = k + 1;
    pointer_ = chunk_.data();
  }
  TileMap map() { return {{-2, -2, 4, 4}, table_.data(), {&pointer_}}; }
  void add(int i, int j, CellWord w) {
    const TileMap m = map();
    chunk_[table_[m.span.place(i, j)]].cell[cell_in_tile(i, j)] += w;
  }
  void tidy() {
    for (std::uint32_t k = 1; k <= 16; ++k)
      for (std::int32_t j = 0; j < kTileCells; ++j) tidy_row(chunk_[k], j);
  }
  /// SPEC 9.2 by the letter, in float64.
  double slow_match(double u, double v, double du, double dv) {
    const TileMap m = map();
    const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
    const int fi = static_cast<int>(std::floor(u - std::sqrt(2.0) * du)) - i,
              fj = static_cast<int>(std::floor(v - std::sqrt(2.0) * dv)) - j;
    double best = -1.0;
    for (int b = -1; b <= 1; ++b)
      for (int a = -1; a <= 1; ++a) {
        const CellWord w = m.cell(i + a, j + b);
        if (!is_occupied(w) || is_occupied(m.cell(i + a + fi, j + b + fj))) continue;
        const double x = i + a + (sum_x_of(w) + 0.5 * hits_of(w)) / (hits_of(w) * 128.0) - u;
        const double y = j + b + (sum_y_of(w) + 0.5 * hits_of(w)) / (hits_of(w) * 128.0) - v;
        if (best < 0.0 || x * x + y * y < best) best = x * x + y * y;
      }
    return best;
  }
  std::vector<Tile> chunk_;
  std::vector<std::uint32_t> table_;
  Tile* pointer_;
};

TEST_F(MatchBeam, EqualsTheDefinitionInFloat64AcrossTiles) {
  Random random{7};
  for (int k = 0; k < 2500; ++k)
    add(static_cast<int>(random() * 128.0f) - 64, static_cast<int>(random() * 128.0f) - 64,
        k % 3 == 0 ? cell_word(20, 1, 30, 40) : ended_at(random(), random()));
  tidy();
  int found = 0, none = 0;
  for (int k = 0; k < 20000; ++k) {
    const float u = 140.0f * random() - 70.0f, v = 140.0f * random() - 70.0f, angle = 6.28f * random();
    const float du = std::cos(angle), dv = std::sin(angle);
    const double slow = slow_match(u, v, du, dv);
    const float fast = match_end(map(), end_of_beam(u, v, du, dv));
    (slow < 0.0 ? none : found) += 1;
    if (slow < 0.0)
      EXPECT_EQ(fast, kNoMatch);
    else
      EXPECT_NEAR(fast, slow, 2e-4);  // coordinates up to 70 cells have 4e-6 of a cell
  }
  EXPECT_GT(found, 3000);
  EXPECT_GT(none, 3000);
}

TEST_F(MatchBeam, AWallSeenFromBehindIsNoMatch) {
  for (int j = -5; j <= 5; ++j)
    for (int i = 3; i < 6; ++i) add(i, j, ended_at(0.5f, 0.5f));  // three cells thick
  tidy();
  EXPECT_GE(match_end(map(), end_of_beam(3.5f, 0.5f, 1.0f, 0.0f)), 0.0f);
  // What is before it is wall as well.
  EXPECT_EQ(match_end(map(), end_of_beam(4.5f, 0.5f, 0.0f, 1.0f)), kNoMatch);
}

// ---- Climbing ---------------------------------------------------------------------------------------------

/// To the end; how many scores it asked for.
template <class Score>
int finish(HillClimb& climb, const Score& score) {
  int asked = 0;
  while (!climb.done()) {
    std::int32_t s[HillClimb::kMoves];
    for (int k = 0; k < climb.wanted(); ++k) s[k] = score(climb.candidate(k)), ++asked;
    climb.take(s);
  }
  return asked;
}

TEST(HillClimb, FindsTheTopOfASmoothHill) {
  HillClimb climb;
  climb.begin({0.3f, -0.2f, 3.1f}, {0.05f, 0.05f, 5}, 100);
  const int asked = finish(climb, [](const SlamPose& p) {
    const float dt = wrap(p.theta - -3.1f);
    return static_cast<std::int32_t>(1e6f - 1e5f * ((p.x - 0.1f) * (p.x - 0.1f) + p.y * p.y + dt * dt));
  });
  EXPECT_NEAR(climb.pose().x, 0.1f, 0.004f);
  EXPECT_NEAR(climb.pose().y, 0.0f, 0.004f);
  EXPECT_NEAR(wrap(climb.pose().theta + 3.1f), 0.0f, 0.004f);  // across half a turn
  EXPECT_LT(asked, 6 * HillClimb::kMostRounds);
}

TEST(HillClimb, IsHeldBackByTheSquareOfTheDistance) {
  constexpr std::size_t kBeams = 1000;
  HillClimb climb;
  climb.begin({0, 0, 0}, {0.05f, 0.05f, 7, 2.0f}, kBeams);
  // Rises by 0.4 per beam and metre along x: against 2 d^2, the top is at 0.1 m.
  finish(climb, [](const SlamPose& p) {
    return static_cast<std::int32_t>(kScoreUnits * kBeams *
                                     (0.5f + 0.4f * p.x - p.y * p.y - p.theta * p.theta));
  });
  EXPECT_NEAR(climb.pose().x, 0.1f, 0.001f);
  EXPECT_NEAR(climb.pose().y, 0.0f, 0.001f);
  EXPECT_NEAR(climb.score(), kScoreUnits * kBeams * 0.52f, kScoreUnits);
}
TEST(HillClimb, StaysWhereNothingIsBetter) {
  HillClimb climb;
  climb.begin({1, 2, 0.5f}, {0.05f, 0.05f, 5}, 100);
  int rounds = 0;
  while (!climb.done()) {
    const std::int32_t flat[HillClimb::kMoves] = {9, 9, 9, 9, 9, 9};
    climb.take(flat);
    ++rounds;
  }
  EXPECT_EQ(rounds, 6);  // the start, and five halvings
  EXPECT_EQ(climb.pose().x, 1.0f);
}

// ---- The Gaussian proposal --------------------------------------------------------------------------------

// The worked example of SPEC 9.3.
TEST(GaussianProposal, MatchesTheWorkedExample) {
  const double offsets[5][3] = {
      {0, 0, 0}, {0.02, 0, 0}, {-0.02, 0, 0.01}, {0, 0.03, 0.03}, {0, -0.03, -0.02}};
  double log_weight[5] = {-8.8, -9.6, -10.6, -11.6, -10.1};
  const auto offset = [&](int k) {
    Vector3 d;
    for (int a = 0; a < 3; ++a) d[a] = offsets[k][a];
    return d;
  };
  const ProposalMoments m = proposal_moments(log_weight, 5, offset);
  EXPECT_NEAR(m.log_eta, -8.133212345210, 1e-11);
  EXPECT_NEAR(m.shift[0], 0.002916165223, 1e-12);
  EXPECT_NEAR(m.shift[1], -0.003260652302, 1e-12);
  EXPECT_NEAR(m.shift[2], -0.001013026584, 1e-12);
  EXPECT_NEAR(m.covariance(0, 0), 1.17704894e-4, 1e-12);
  EXPECT_NEAR(m.covariance(1, 1), 1.43378586e-4, 1e-12);
  EXPECT_NEAR(m.covariance(2, 2), 9.1517137e-5, 1e-12);
  EXPECT_NEAR(m.covariance(0, 1), 9.508601e-6, 1e-12);
  EXPECT_NEAR(m.covariance(0, 2), -1.4017249e-5, 1e-12);
  EXPECT_NEAR(m.covariance(1, 2), 1.08735644e-4, 1e-12);
  const double volume = 0.1 * 0.1 * 0.08;
  EXPECT_NEAR(m.log_eta + std::log(volume / 5.0), -16.873549087940, 1e-11);
}

TEST(GaussianProposal, NodesLieInTheMiddleOfEqualParts) {
  const ProposalBox box{0.06, 0.04};
  EXPECT_NEAR(box.volume(), 0.12 * 0.12 * 0.08, 1e-15);
  Vector3 sum;
  for (int k = 0; k < kBoxPoints; ++k) sum = plus(sum, 1.0, box.offset(k));
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(sum[a], 0.0, 1e-12);
  EXPECT_NEAR(box.offset(0)[0], -0.048, 1e-15);
  EXPECT_NEAR(box.offset(kBoxPoints - 1)[2], 0.032, 1e-15);
}

// The sum times the part's volume is the integral of the product: of two Gaussians it is known.
TEST(GaussianProposal, EtaTimesTheVolumeIsThePredictiveLikelihood) {
  const ProposalBox box{0.12, 0.12};
  const Cholesky3 motion = cholesky(diagonal3(0.05 * 0.05, 0.06 * 0.06, 0.05 * 0.05));
  const Cholesky3 scan = cholesky(diagonal3(0.06 * 0.06, 0.05 * 0.05, 0.07 * 0.07));
  double log[kBoxPoints];
  for (int k = 0; k < kBoxPoints; ++k)
    log[k] = log_density(motion, box.offset(k)) + log_density(scan, box.offset(k));
  const auto offset = [&](int k) { return box.offset(k); };
  const ProposalMoments m = proposal_moments(log, kBoxPoints, offset);
  const Cholesky3 both = cholesky(diagonal3(0.0061, 0.0061, 0.0074));
  EXPECT_NEAR(m.log_eta + std::log(box.volume() / kBoxPoints), log_density(both, Vector3{}), 0.02);
  EXPECT_NEAR(m.covariance(0, 0), 1.0 / (1.0 / 0.0025 + 1.0 / 0.0036), 5e-5);
}

// ---- The paths of particles -------------------------------------------------------------------------------

TEST(PathTree, EveryParticleKeepsItsPath) {
  PathTree tree(3);
  tree.add({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0, 0, 0});
  tree.add({{10, 0, 0}, {11, 0, 0}, {12, 0, 0}}, {2, 2, 0});
  tree.add({{20, 0, 0}, {21, 0, 0}, {22, 0, 0}}, {0, 1, 1});
  const std::vector<Pose> path = tree.path(2);
  ASSERT_EQ(path.size(), 3u);
  EXPECT_EQ(path[0].x_m, 2.0);
  EXPECT_EQ(path[1].x_m, 11.0);
  EXPECT_EQ(path[2].x_m, 22.0);
  EXPECT_EQ(tree.distinct(), (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_EQ(tree.nodes(), 6u);  // what nobody descends from is forgotten
}

TEST(PathTree, ForgetsWhatNobodyDescendsFrom) {
  constexpr std::size_t kParticles = 30, kSteps = 2000;
  PathTree tree(kParticles);
  std::vector<std::vector<std::size_t>> slow(kParticles);
  std::uint32_t state = 3;
  for (std::size_t step = 0; step < kSteps; ++step) {
    std::vector<Pose> poses;
    std::vector<std::uint32_t> ancestor;
    std::vector<std::vector<std::size_t>> next;
    for (std::size_t j = 0; j < kParticles; ++j) {
      ancestor.push_back(step % 5 == 0 ? (state = state * 1664525u + 1013904223u) % kParticles
                                       : static_cast<std::uint32_t>(j));
      next.push_back(slow[ancestor[j]]);
      next[j].push_back(step * kParticles + j);
      poses.push_back({static_cast<double>(step * kParticles + j), 0, 0});
    }
    slow = std::move(next);
    tree.add(poses, ancestor);
  }
  for (std::size_t j = 0; j < kParticles; ++j) {
    const std::vector<Pose> path = tree.path(j);
    for (std::size_t k = 0; k < kSteps; ++k) ASSERT_EQ(path[k].x_m, static_cast<double>(slow[j][k]));
  }
  EXPECT_LT(tree.nodes(), kSteps + kParticles * kSteps / 10);
}

}  // namespace
}  // namespace parloc
