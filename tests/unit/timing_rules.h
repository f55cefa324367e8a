// How long the tests of `parloc bench` may measure.
#pragma once

#include "tools/bench/steps/measure.h"

namespace parloc::tools::bench {

inline TimingRules rules_of(double seconds, int least, int most) {
  TimingRules rules;
  rules.seconds = seconds;
  rules.least_steps = least;
  rules.most_steps = most;
  rules.warm_up_steps = 2;
  rules.warm_up_seconds = 0.0;
  return rules;
}

}  // namespace parloc::tools::bench
