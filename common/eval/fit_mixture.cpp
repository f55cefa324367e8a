#include "common/eval/fit_mixture.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace parloc {
namespace {

constexpr double kLeastSigma_m = 1e-3, kLeastLambda = 1e-3, kMostLambda = 100.0;
constexpr double kLeastExpected_m = 1e-3;

double normal_density(double x) {
  return 0.39894228040143267794 * std::exp(-0.5 * x * x);
}
/// 1 - Phi(x).
double upper_tail(double x) {
  return 0.5 * std::erfc(x * 0.70710678118654752440);
}
/// phi(x) / (1 - Phi(x)), for large x by its asymptote.
double hazard(double x) {
  return x < 25.0 ? normal_density(x) / upper_tail(x) : x + 1.0 / x;
}

/// What each cause contributes to the likelihood of one beam.
struct Causes {
  double hit = 0, in_front = 0, max = 0, rand = 0;
  double sum() const { return hit + in_front + max + rand; }
};

Causes causes(const Mixture& m, const RangePair& p, double range_max_m) {
  const double y = p.measured_m, e = p.expected_m;
  const bool wall = e < range_max_m;
  if (y >= range_max_m)
    return {m.z_hit * (wall ? upper_tail((range_max_m - e) / m.sigma_m) : 1.0), 0.0, m.z_max, 0.0};
  const double reach = std::max(std::min(e, range_max_m), kLeastExpected_m);
  Causes c;
  c.hit = wall ? m.z_hit * normal_density((y - e) / m.sigma_m) / m.sigma_m : 0.0;
  if (y <= reach)
    c.in_front =
        m.z_short * m.lambda_per_m * std::exp(-m.lambda_per_m * y) / -std::expm1(-m.lambda_per_m * reach);
  c.rand = m.z_rand / range_max_m;
  return c;
}

/// Sums over all beams of one round.
struct Sums {
  double log_likelihood = 0;
  Causes count;
  double square = 0, seen = 0;      // of hits on walls: expected squared error, how many
  double slope = 0, curvature = 0;  // of the short beams' log-likelihood over lambda
};

/// Expected squared error of a hit, whose true range is somewhere beyond the maximum if it was a miss.
double squared_error(const Mixture& m, const RangePair& p, double range_max_m) {
  if (p.measured_m < range_max_m) {
    const double d = p.measured_m - p.expected_m;
    return d * d;
  }
  const double a = (range_max_m - p.expected_m) / m.sigma_m;
  return m.sigma_m * m.sigma_m * (1.0 + a * hazard(a));
}

Sums expect(const RangePairs& ranges, const Mixture& m) {
  Sums s;
  for (const RangePair& p : ranges.pairs) {
    const Causes c = causes(m, p, ranges.range_max_m);
    const double all = c.sum();
    s.log_likelihood += std::log(all);
    const double hit = c.hit / all, in_front = c.in_front / all;
    s.count.hit += hit, s.count.in_front += in_front, s.count.max += c.max / all,
        s.count.rand += c.rand / all;
    if (p.expected_m < ranges.range_max_m) {
      s.square += hit * squared_error(m, p, ranges.range_max_m);
      s.seen += hit;
    }
    if (in_front > 0.0) {
      // log(lambda) - lambda y - log(1 - exp(-lambda reach)) is concave in lambda.
      const double reach = std::max(std::min<double>(p.expected_m, ranges.range_max_m), kLeastExpected_m);
      const double l = m.lambda_per_m, grow = std::expm1(l * reach);
      s.slope += in_front * (1.0 / l - p.measured_m - reach / grow);
      s.curvature += in_front * (-1.0 / (l * l) + reach * reach * (grow + 1.0) / (grow * grow));
    }
  }
  return s;
}

/// The short beams' part of the expected log-likelihood, for the responsibilities that `old` gives.
double short_log_likelihood(const RangePairs& ranges, const Mixture& old, double lambda) {
  double sum = 0.0;
  for (const RangePair& p : ranges.pairs) {
    const Causes c = causes(old, p, ranges.range_max_m);
    if (c.in_front <= 0.0) continue;
    const double reach = std::max(std::min<double>(p.expected_m, ranges.range_max_m), kLeastExpected_m);
    sum += c.in_front / c.sum() *
           (std::log(lambda) - lambda * p.measured_m - std::log(-std::expm1(-lambda * reach)));
  }
  return sum;
}

/// A Newton step, halved until it does not go downhill.
double better_lambda(const RangePairs& ranges, const Mixture& m, const Sums& s) {
  if (!(s.count.in_front > 0.0) || !std::isfinite(s.slope) || !(s.curvature < 0.0)) return m.lambda_per_m;
  double step = -s.slope / s.curvature;
  const double now = short_log_likelihood(ranges, m, m.lambda_per_m);
  for (int halving = 0; halving < 20; ++halving, step *= 0.5) {
    const double lambda = std::clamp(m.lambda_per_m + step, kLeastLambda, kMostLambda);
    if (short_log_likelihood(ranges, m, lambda) >= now) return lambda;
  }
  return m.lambda_per_m;
}

Mixture maximise(const RangePairs& ranges, const Mixture& m, const Sums& s) {
  const double n = static_cast<double>(ranges.pairs.size());
  Mixture next{s.count.hit / n, s.count.in_front / n,       s.count.max / n, s.count.rand / n,
               m.sigma_m,       better_lambda(ranges, m, s)};
  if (s.seen > 0.0) next.sigma_m = std::max(std::sqrt(s.square / s.seen), kLeastSigma_m);
  return next;
}

}  // namespace

double mixture_likelihood(const Mixture& m, const RangePair& pair, double range_max_m) {
  return causes(m, pair, range_max_m).sum();
}

MixtureFit fit_mixture(const RangePairs& ranges, Mixture start, int most_rounds, double least_gain,
                       const std::function<bool(int round)>& keep_going) {
  if (ranges.pairs.size() < kFewestPairs)
    throw Error(ErrorKind::input, "learning the beam mixture: expected at least " +
                                      std::to_string(kFewestPairs) + " beams with a true pose, got " +
                                      std::to_string(ranges.pairs.size()));
  MixtureFit fit;
  fit.mixture = start;
  const double n = static_cast<double>(ranges.pairs.size());
  for (int round = 0; round < most_rounds; ++round) {
    const Sums s = expect(ranges, fit.mixture);
    fit.log_likelihood.push_back(s.log_likelihood / n);
    const std::size_t k = fit.log_likelihood.size();
    fit.converged = k > 1 && fit.log_likelihood[k - 1] - fit.log_likelihood[k - 2] < least_gain;
    if (fit.converged || (keep_going && !keep_going(round))) break;
    fit.mixture = maximise(ranges, fit.mixture, s);
  }
  return fit;
}

SensorConfig with_mixture(SensorConfig config, const Mixture& m) {
  constexpr double kLeastShare = 1e-3;
  double shares[] = {m.z_hit, std::max(m.z_short, kLeastShare), std::max(m.z_max, kLeastShare),
                     std::max(m.z_rand, kLeastShare)};
  const double sum = shares[0] + shares[1] + shares[2] + shares[3];
  // Four decimals, as they are printed; what is left is the hit's.
  for (double& share : shares) share = std::rint(share / sum * 1e4) / 1e4;
  config.z_short = shares[1], config.z_max = shares[2], config.z_rand = shares[3];
  config.z_hit = std::rint((1.0 - shares[1] - shares[2] - shares[3]) * 1e4) / 1e4;
  config.sigma_hit = std::max(std::rint(m.sigma_m * 1e4) / 1e4, 1e-3);
  config.lambda_short = std::max(std::rint(m.lambda_per_m * 1e4) / 1e4, 1e-3);
  return config;
}

}  // namespace parloc
