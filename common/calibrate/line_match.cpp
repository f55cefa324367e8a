#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/calibrate/line_scan.h"
#include "common/math/portable64.h"
#include "common/math/quantile.h"

namespace parloc {
namespace {

/// Pieces farther apart than the gate are not the same wall: wide at first, for the guess may be off, then
/// narrower from round to round.
constexpr double kFirstGate_m = 0.6, kLastGate_m = 0.12, kNarrower = 0.75;
constexpr int kMostRounds = 40;
/// Nor are walls that look elsewhere: the cosine between their normals.
constexpr double kLeastCosine = 0.8;
/// The error of a piece is not taken to be less than this, nor a match surer than a prior of this width.
constexpr double kLeastSigma_m = 0.003, kLoosest_m = 1.0, kLoosest_rad = 1.0;
/// Neighbouring pieces share beams, and walls are not what a straight line says: so many of them are worth
/// one.
constexpr double kShared = 4.0;

struct Pairing {
  double normal_x, normal_y, error_m, lever_m;
  double normal_variance;
};

/// The nearest piece of `reference` to a place, looked for around its bearing; -1 if none is in reach.
std::ptrdiff_t nearest(const LineScan& reference, double x, double y, double gate_m) {
  const auto n = static_cast<std::ptrdiff_t>(reference.pieces.size());
  const double range_m = std::sqrt(x * x + y * y);
  const double reach_rad = gate_m < 0.9 * range_m ? 1.2 * gate_m / range_m : kPi;
  const double bearing = portable_atan2_64(y, x);
  const auto& all = reference.bearings_rad;
  const std::ptrdiff_t start = std::lower_bound(all.begin(), all.end(), bearing) - all.begin();
  std::ptrdiff_t best = -1;
  double best_sq = gate_m * gate_m;
  const auto look = [&](std::ptrdiff_t k) {
    const std::ptrdiff_t at = ((k % n) + n) % n;
    if (std::fabs(wrap64(all[static_cast<std::size_t>(at)] - bearing)) > reach_rad) return false;
    const WallPiece& p = reference.pieces[static_cast<std::size_t>(at)];
    const double dx = p.x_m - x, dy = p.y_m - y, sq = dx * dx + dy * dy;
    if (sq < best_sq) best_sq = sq, best = at;
    return true;
  };
  std::ptrdiff_t looked = 0;
  for (std::ptrdiff_t k = start; looked < n && look(k); ++k) ++looked;
  for (std::ptrdiff_t k = start - 1; looked < n && look(k); --k) ++looked;
  return best;
}

void pair_up(const LineScan& reference, const LineScan& moved, const Pose& step, double gate_m,
             std::vector<Pairing>& pairings) {
  pairings.clear();
  const SinCos64 turn = portable_sincos64(step.theta_rad);
  for (const WallPiece& p : moved.pieces) {
    const double rx = turn.cos * p.x_m - turn.sin * p.y_m, ry = turn.sin * p.x_m + turn.cos * p.y_m;
    const double x = rx + step.x_m, y = ry + step.y_m;
    const std::ptrdiff_t at = nearest(reference, x, y, gate_m);
    if (at < 0) continue;
    const WallPiece& q = reference.pieces[static_cast<std::size_t>(at)];
    double nx = turn.cos * p.normal_x - turn.sin * p.normal_y;
    double ny = turn.sin * p.normal_x + turn.cos * p.normal_y;
    const double cosine = nx * q.normal_x + ny * q.normal_y;
    if (std::fabs(cosine) < kLeastCosine) continue;
    const double sign = cosine < 0.0 ? -1.0 : 1.0;
    nx = q.normal_x + sign * nx, ny = q.normal_y + sign * ny;
    const double length = std::sqrt(nx * nx + ny * ny);
    nx /= length, ny /= length;
    const double error_m = nx * (x - q.x_m) + ny * (y - q.y_m);
    pairings.push_back({nx, ny, error_m, ny * rx - nx * ry, 0.25 * (p.normal_variance + q.normal_variance)});
  }
}

double sigma_of(const std::vector<Pairing>& pairings) {
  std::vector<double> errors;
  for (const Pairing& p : pairings) errors.push_back(std::fabs(p.error_m));
  return std::max(1.4826 * median(ascending(std::move(errors))), kLeastSigma_m);
}

/// One step of Gauss and Newton with the weights of Cauchy; in the frame of the reference.
NormalEquations<3> equations_of(const std::vector<Pairing>& pairings, double sigma_m) {
  NormalEquations<3> equations;
  for (const Pairing& p : pairings) {
    const double e = p.error_m / (2.0 * sigma_m);
    equations.add({p.normal_x, p.normal_y, p.lever_m}, -p.error_m, 1.0 / (1.0 + e * e));
  }
  return equations;
}

/// K M K^T of a symmetric M, of which the lower triangle is read.
Matrix3 congruent(const Matrix3& k, const Matrix3& m) {
  Matrix3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b)
          out[i][j] += k[i][a] * m[std::max(a, b)][std::min(a, b)] * k[j][b];
  return out;
}

/// Normals that are off by chance seem to tell of places along a wall, too; what they would is taken off.
void take_off_chance(const std::vector<Pairing>& pairings, double sigma_m, NormalEquations<3>& equations) {
  std::array<std::array<double, 2>, 2> chance{};
  for (const Pairing& p : pairings) {
    const double e = p.error_m / (2.0 * sigma_m);
    const double weight = p.normal_variance / (1.0 + e * e);
    chance[0][0] += weight * p.normal_y * p.normal_y;
    chance[1][1] += weight * p.normal_x * p.normal_x;
    chance[0][1] -= weight * p.normal_x * p.normal_y;
  }
  auto& m = equations.matrix;
  // The direction in which the scan tells least.
  const double middle = 0.5 * (m[0][0] + m[1][1]), half = 0.5 * (m[0][0] - m[1][1]);
  const double least = middle - std::sqrt(half * half + m[1][0] * m[1][0]);
  double ex = m[1][0], ey = least - m[0][0];
  if (std::fabs(m[1][1] - least) > std::fabs(m[0][0] - least)) ex = least - m[1][1], ey = m[1][0];
  const double length_sq = ex * ex + ey * ey;
  if (!(length_sq > 0.0)) return;
  const double by_chance =
      (chance[0][0] * ex * ex + 2.0 * chance[0][1] * ex * ey + chance[1][1] * ey * ey) / length_sq;
  constexpr double kSurely = 3.0;  // times what is expected
  const double left = std::max(least - kSurely * by_chance, 0.0);
  // All that it tells in that direction gets the factor, couplings to the turn included: it stays a
  // covariance.
  const double shrunk = 1.0 - std::sqrt(least > 0.0 ? left / least : 0.0);
  std::array<std::array<double, 3>, 3> keep{};
  const std::array<double, 3> e{ex / std::sqrt(length_sq), ey / std::sqrt(length_sq), 0.0};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) keep[i][j] = (i == j ? 1.0 : 0.0) - shrunk * e[i] * e[j];
  m = congruent(keep, m);
}

void add_prior(NormalEquations<3>& equations, double sigma_m) {
  const double variance = kShared * sigma_m * sigma_m;
  equations.matrix[0][0] += variance / (kLoosest_m * kLoosest_m);
  equations.matrix[1][1] += variance / (kLoosest_m * kLoosest_m);
  equations.matrix[2][2] += variance / (kLoosest_rad * kLoosest_rad);
}

}  // namespace

LineMatch match_lines(const LineScan& reference, const LineScan& moved, const Pose& guess) {
  LineMatch match{.step = guess};
  const std::size_t fewer = std::min(reference.pieces.size(), moved.pieces.size());
  if (fewer < LineMatch::kFewest) return match;
  std::vector<Pairing> pairings;
  double gate_m = kFirstGate_m, sigma_m = kLeastSigma_m;
  for (int round = 0; round < kMostRounds; ++round) {
    pair_up(reference, moved, match.step, gate_m, pairings);
    if (pairings.size() < LineMatch::kFewest) return match;
    sigma_m = sigma_of(pairings);
    NormalEquations<3> equations = equations_of(pairings, sigma_m);
    add_prior(equations, sigma_m);
    if (!equations.factor()) return match;
    const std::array<double, 3> d = equations.solve(equations.right);
    match.step = {match.step.x_m + d[0], match.step.y_m + d[1], wrap64(match.step.theta_rad + d[2])};
    const bool still = std::fabs(d[0]) < 1e-5 && std::fabs(d[1]) < 1e-5 && std::fabs(d[2]) < 1e-5;
    if (still && gate_m == kLastGate_m) break;
    gate_m = still ? kLastGate_m : std::max(kNarrower * gate_m, kLastGate_m);
  }
  NormalEquations<3> equations = equations_of(pairings, sigma_m);
  take_off_chance(pairings, sigma_m, equations);
  add_prior(equations, sigma_m);
  Matrix3 full = equations.matrix;
  if (!invert(full, match.covariance)) return match;
  double squares = 0.0;
  for (const Pairing& p : pairings) {
    if (std::fabs(p.error_m) > 4.0 * sigma_m + kLeastSigma_m) continue;
    squares += p.error_m * p.error_m;
    ++match.pieces;
  }
  for (auto& row : match.covariance)
    for (double& value : row) value *= kShared * sigma_m * sigma_m;
  match.rms_m = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(match.pieces, 1)));
  match.share = static_cast<double>(match.pieces) / static_cast<double>(fewer);
  return match;
}

}  // namespace parloc
