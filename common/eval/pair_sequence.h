// The difference of two success rates over pairs of trials, with an interval that holds however often one
// looks.
#pragma once

#include <cstddef>

namespace parloc {

/// Of pairs of trials, each a success or not.
struct PairCounts {
  std::size_t alike = 0;                        ///< Both succeeded, or neither.
  std::size_t first_only = 0, second_only = 0;  ///< One succeeded.
  std::size_t pairs() const { return alike + first_only + second_only; }
};

/// The second's rate less the first's.
struct DifferenceInterval {
  double low = -1.0, high = 1.0;
};

/// Robbins' mixture as RateSequence has it, of three outcomes: a Dirichlet prior (1/2, 1/2, 1) of "first
/// only", "second only" and "alike". It leaves a set of rates of these that holds for all numbers of pairs
/// together but with a probability of `error`; this is what that set has of differences. The same bits on
/// every machine.
DifferenceInterval difference_interval(const PairCounts& counts, double error);

}  // namespace parloc
