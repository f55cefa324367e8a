#include "common/calibrate/mount_fit.h"

#include <algorithm>
#include <cmath>

#include "common/calibrate/mount_residuals.h"
#include "common/calibrate/mount_start.h"
#include "common/math/portable64.h"
#include "common/math/quantile.h"

namespace parloc {
namespace {

constexpr int kMostIterations = 40;
/// Of Student's t: with so few degrees of freedom a slip counts for little.
constexpr double kFreedom = 4.0;
/// Squared error over its variance from which a motion counts as unlike.
constexpr double kUnlike = 30.0;
/// By how much the better of two sides must be more likely (twice the logarithm).
constexpr double kSurelyBetter = 30.0;
/// What is taken to be known before: nearly nothing. Keeps what a drive leaves open from running away.
constexpr Unknowns kPrior{2.0, 2.0, 3.0, 0.5, 0.5, 0.3, 0.5, 0.5};
/// Widths are not taken to be less: [m, m, rad].
constexpr std::array<double, 3> kLeastWidth{0.0005, 0.0005, 0.0003};
/// Fewer motions of a kind than this share their widths with the other kind.
constexpr std::size_t kFewestOfKind = 8;
/// Of fewer motions nothing is told: what is found fits them too well for its standard deviations to be
/// right.
constexpr std::size_t kFewestMotions = 12;
/// A motion is of one kind if it has no more than this share of the other.
constexpr double kMixed = 0.25;

using Equations = NormalEquations<kUnknowns>;

/// Noise of the odometry over one step between key scans, of a way and of a turn; variances grow with either.
struct Widths {
  std::array<std::array<double, 3>, 2> of{{{0.02, 0.02, 0.02}, {0.02, 0.02, 0.02}}};
};

struct Problem {
  const std::vector<PairMotion>& pairs;
  OdometryPath& path;
  Unknowns stated;
  std::array<bool, kUnknowns> free;
};

struct Solution {
  Unknowns at{}, sigma{};
  Widths widths;
  double minus_log_likelihood = 0.0;
  std::size_t unlike = 0;
};

Matrix3 weight_of(const Residual& r, const Widths& widths, double& log_det) {
  Matrix3 sum = r.covariance, weight{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double way = widths.of[0][k], turn = widths.of[1][k];
    sum[k][k] += way * way * r.ways + turn * turn * r.turns + kLeastWidth[k] * kLeastWidth[k];
  }
  const double det = sum[0][0] * (sum[1][1] * sum[2][2] - sum[1][2] * sum[1][2]) -
                     sum[0][1] * (sum[0][1] * sum[2][2] - sum[1][2] * sum[0][2]) +
                     sum[0][2] * (sum[0][1] * sum[1][2] - sum[1][1] * sum[0][2]);
  log_det = portable_log64(std::max(det, 1e-300));
  // The lower triangle is what invert() reads.
  if (!invert(sum, weight)) weight = {};
  return weight;
}

std::array<double, 3> times(const Matrix3& m, const std::array<double, 3>& v) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out[i] += m[i][j] * v[j];
  return out;
}

double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Robustly, from the errors that the matches do not explain.
Widths widths_of(const std::vector<Residual>& residuals) {
  Widths widths;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> errors, explained;
      for (const bool all : {false, true}) {
        if (all && errors.size() >= kFewestOfKind) break;
        errors.clear(), explained.clear();
        for (const Residual& r : residuals) {
          const double own = kind == 0 ? r.ways : r.turns, other = kind == 0 ? r.turns : r.ways;
          if (!all && other > kMixed * own) continue;
          const double size = all ? std::max(r.ways + r.turns, kMixed) : std::max(own, kMixed);
          errors.push_back(std::fabs(r.error[axis]) / std::sqrt(size));
          explained.push_back(r.covariance[axis][axis] / size);
        }
      }
      const double spread = 1.4826 * median(ascending(std::move(errors)));
      const double rest = spread * spread - median(ascending(std::move(explained)));
      widths.of[kind][axis] = std::max(std::sqrt(std::max(rest, 0.04 * spread * spread)), kLeastWidth[axis]);
    }
  }
  return widths;
}

double student_weight(double squared) {
  return (kFreedom + 3.0) / (kFreedom + squared);
}

/// How fast the weighed error grows with the error, as a share of its weight, on average over directions:
/// less than 1, for the weight falls meanwhile.
double student_slope(double squared) {
  return 1.0 - (2.0 / 3.0) * squared / (kFreedom + squared);
}

/// For the standard deviations: how fast the equations' right sides change, and how the motions' own parts of
/// them scatter.
struct Sandwich {
  Equations slope, scatter;
};

/// The equations about `at`.
Equations equations_at(const Problem& problem, const std::vector<Residual>& residuals,
                       const Derivatives& derivatives, const Unknowns& at, Solution& solution,
                       Sandwich& sandwich) {
  Equations equations;
  solution.minus_log_likelihood = 0.0;
  solution.unlike = 0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    double log_det = 0.0;
    const Matrix3 weight = weight_of(residuals[k], solution.widths, log_det);
    const double squared = dot(residuals[k].error, times(weight, residuals[k].error));
    const double robust = student_weight(squared);
    solution.unlike += squared > kUnlike ? 1 : 0;
    solution.minus_log_likelihood += (kFreedom + 3.0) * portable_log64(1.0 + squared / kFreedom) + log_det;
    std::array<double, kUnknowns> gradient{};
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      if (!problem.free[i]) continue;
      const std::array<double, 3> weighed = times(weight, derivatives[i][k]);
      gradient[i] = robust * dot(weighed, residuals[k].error);
      equations.right[i] -= gradient[i];
      for (std::size_t j = 0; j <= i; ++j) {
        if (!problem.free[j]) continue;
        const double part = robust * dot(weighed, derivatives[j][k]);
        equations.matrix[i][j] += part;
        sandwich.slope.matrix[i][j] += student_slope(squared) * part;
      }
    }
    sandwich.scatter.add(gradient, 0.0, 1.0);
  }
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    const double information = problem.free[i] ? 1.0 / (kPrior[i] * kPrior[i]) : 1.0;
    equations.matrix[i][i] += information;
    sandwich.slope.matrix[i][i] += information;
    if (problem.free[i] && i != kYaw) equations.right[i] -= information * (at[i] - problem.stated[i]);
  }
  return equations;
}

/// Factors the slope.
Unknowns sigmas_of(Sandwich& parts, std::size_t motions) {
  Unknowns sigma = kPrior;
  if (!parts.slope.factor()) return sigma;
  // The unknowns and the widths, found from the same errors, make these too small: by about four motions'
  // worth.
  const double ratio = static_cast<double>(motions) / std::max(1.0, static_cast<double>(motions) - 4.0);
  const double few = ratio * ratio;
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    const std::array<double, kUnknowns> column = parts.slope.inverse_column(i);
    double sandwich = 0.0;
    for (std::size_t a = 0; a < kUnknowns; ++a)
      for (std::size_t b = 0; b < kUnknowns; ++b)
        sandwich += column[a] * column[b] * parts.scatter.matrix[std::max(a, b)][std::min(a, b)];
    sigma[i] = std::sqrt(few * std::max(sandwich, column[i]));
  }
  return sigma;
}

void keep_within_reason(Unknowns& at) {
  at[kYaw] = wrap64(at[kYaw]);
  for (const std::size_t i : {kDrive, kTurn, kSide}) at[i] = std::clamp(at[i], -0.7, 0.7);
  at[kDelay] = std::clamp(at[kDelay], -2.0, 2.0);
  for (const std::size_t i : {kX, kY}) at[i] = std::clamp(at[i], -20.0, 20.0);
}

Solution solve(const Problem& problem, const Unknowns& start) {
  Solution solution;
  solution.at = start;
  for (int round = 0;; ++round) {
    const std::vector<Residual> residuals =
        residuals_at(problem.pairs, problem.path, solution.at, problem.free[kSide]);
    const Derivatives derivatives = derivatives_at(problem.pairs, problem.path, solution.at, problem.free);
    solution.widths = widths_of(residuals);
    Sandwich sandwich;
    Equations equations = equations_at(problem, residuals, derivatives, solution.at, solution, sandwich);
    const std::array<double, kUnknowns> right = equations.right;
    if (!equations.factor()) return solution;
    solution.sigma = sigmas_of(sandwich, residuals.size());
    const std::array<double, kUnknowns> step = equations.solve(right);
    double largest = 0.0;
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      solution.at[i] += step[i];
      largest = std::max(largest, std::fabs(step[i]) / solution.sigma[i]);
    }
    keep_within_reason(solution.at);
    if (largest < 1e-3 || round >= kMostIterations) return solution;
  }
}

/// What the drive leaves open is put back to what was stated, and the rest found again; until nothing more is
/// open. Standard deviations are the largest on the way: what was put back is not taken to be known.
Solution solve_what_is_determined(Problem& problem, const Unknowns& start,
                                  std::array<bool, kUnknowns>& determined) {
  Solution solution = solve(problem, start);
  for (;;) {
    Unknowns at = solution.at;
    bool all = true;
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      const double unit = i == kDrive || i == kTurn || i == kSide ? portable_exp64(at[i]) : 1.0;
      determined[i] = problem.free[i] && unit * solution.sigma[i] < loosest_sigma(static_cast<Unknown>(i));
      if (determined[i]) continue;
      all = all && !problem.free[i];
      problem.free[i] = false;
      at[i] = problem.stated[i];
    }
    if (all) return solution;
    const Unknowns before = solution.sigma;
    solution = solve(problem, at);
    for (std::size_t i = 0; i < kUnknowns; ++i) solution.sigma[i] = std::max(solution.sigma[i], before[i]);
  }
}

Solution solve_side(const LidarMotions& lidar, OdometryPath& path, const Mount& stated, bool omni,
                    bool upside_down, std::array<bool, kUnknowns>& determined) {
  const std::vector<PairMotion> pairs = pair_motions(lidar, upside_down);
  Problem problem{pairs, path, {}, {}};
  problem.free.fill(true);
  problem.free[kSide] = omni;
  problem.stated[kX] = stated.T_base_sensor.x_m, problem.stated[kY] = stated.T_base_sensor.y_m;
  problem.stated[kYaw] = stated.T_base_sensor.theta_rad;
  return solve_what_is_determined(problem, start_of(pairs, path), determined);
}

}  // namespace

double loosest_sigma(Unknown unknown) {
  constexpr Unknowns loosest{0.05, 0.05, 3.0 * kPi / 180.0, 0.03, 0.03, 0.05, kPi / 180.0, 0.03};
  return loosest[static_cast<std::size_t>(unknown)];
}

Mount MountFit::mount() const {
  return {{(*this)[Unknown::x].value, (*this)[Unknown::y].value, (*this)[Unknown::yaw].value}, upside_down};
}

OdometryScales MountFit::scales() const {
  return {(*this)[Unknown::drive].value, (*this)[Unknown::side].value, (*this)[Unknown::turn].value,
          (*this)[Unknown::drift].value};
}

MountFit fit_mount(const LidarMotions& lidar, OdometryPath& path, const Mount& stated, bool omni) {
  MountFit fit;
  fit.upside_down = stated.upside_down;
  fit.motions = lidar.usable();
  Unknowns at{};
  at[kX] = stated.T_base_sensor.x_m, at[kY] = stated.T_base_sensor.y_m;
  at[kYaw] = stated.T_base_sensor.theta_rad;
  Unknowns sigma = kPrior;
  std::array<bool, kUnknowns> determined{};
  if (fit.motions >= kFewestMotions && !path.empty()) {
    std::array<bool, kUnknowns> other_determined{};
    const bool as_stated = stated.upside_down;
    const Solution same = solve_side(lidar, path, stated, omni, as_stated, determined);
    const Solution other = solve_side(lidar, path, stated, omni, !as_stated, other_determined);
    const double better = same.minus_log_likelihood - other.minus_log_likelihood;
    fit.side_known = std::fabs(better) > kSurelyBetter;
    const bool turned_over = fit.side_known && better > 0.0;
    const Solution& best = turned_over ? other : same;
    if (turned_over) fit.upside_down = !as_stated, determined = other_determined;
    at = best.at, sigma = best.sigma, fit.unlike = best.unlike;
  }
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    const bool is_scale = i == kDrive || i == kTurn || i == kSide;
    const double value = is_scale ? portable_exp64(at[i]) : at[i];
    fit.unknown[i] = {value, is_scale ? value * sigma[i] : sigma[i], determined[i]};
  }
  if (!omni) fit.unknown[kSide] = fit.unknown[kDrive];
  return fit;
}

}  // namespace parloc
