// Measures what the published tables have: 15 sizes, for each scene, cloud and variant.
#pragma once

#include <vector>

#include "tools/bench/plan.h"
#include "tools/bench/results.h"
#include "tools/bench/steps/control.h"
#include "tools/bench/steps/scenes.h"

namespace parloc::tools::bench {

/// The variants of one size are measured one right after the other, since their ratios are what counts. Adds
/// to `results`; on an interruption what is finished stays.
void measure_tables(const Plan& plan, const std::vector<Scene>& scenes, const Control& control,
                    Results& results);

}  // namespace parloc::tools::bench
