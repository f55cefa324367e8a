#include "common/eval/pair_sequence.h"

#include <algorithm>
#include <cmath>

#include "common/math/log_gamma.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

/// count log(rate); as good as minus infinity where what was seen is impossible.
double term(double count, double rate) {
  if (count <= 0.0) return 0.0;
  return rate > 0.0 ? count * portable_log64(rate) : -1e300;
}

/// The largest log-likelihood of those rates whose difference, high's less low's, is `difference` >= 0.
double log_likelihood(double low, double high, double alike, double difference) {
  const double n = low + high + alike, rest = 1.0 - difference;
  // The rate x of `low`, where the derivative by x is zero: 2 n x^2 - b x - low rest difference = 0.
  const double b = low * (rest - 2.0 * difference) + high * rest - 2.0 * alike * difference;
  const double root = std::sqrt(b * b + 8.0 * n * low * rest * difference);
  const double x = std::clamp((b + root) / (4.0 * n), 0.0, 0.5 * rest);
  return term(low, x) + term(high, x + difference) + term(alike, rest - 2.0 * x);
}

/// The largest difference, high's less low's, that is not excluded.
double largest_difference(double low, double high, double alike, double least_log_likelihood) {
  double inside = (high - low) / (low + high + alike), outside = 1.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (inside + outside);
    const double likelihood =
        middle >= 0.0 ? log_likelihood(low, high, alike, middle) : log_likelihood(high, low, alike, -middle);
    (likelihood > least_log_likelihood ? inside : outside) = middle;
  }
  return outside;
}

}  // namespace

DifferenceInterval difference_interval(const PairCounts& counts, double error) {
  if (counts.pairs() == 0) return {};
  const auto first = static_cast<double>(counts.first_only), second = static_cast<double>(counts.second_only),
             alike = static_cast<double>(counts.alike);
  const double log_mixture = log_gamma(first + 0.5) + log_gamma(second + 0.5) + log_gamma(alike + 1.0) -
                             log_gamma(first + second + alike + 2.0) - 2.0 * log_gamma(0.5);
  const double least = log_mixture + portable_log64(error);
  return {-largest_difference(second, first, alike, least), largest_difference(first, second, alike, least)};
}

}  // namespace parloc
