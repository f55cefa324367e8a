// How `parloc` scales: with particles, beams and threads, and the largest size that fits in a budget of time.
#pragma once

#include <array>
#include <vector>

#include "tools/bench/plan.h"
#include "tools/bench/results.h"
#include "tools/bench/steps/control.h"
#include "tools/bench/steps/scenes.h"

namespace parloc::tools::bench {

/// 1024 to 16,777,216 by factors of 4; fewer with --quick.
std::vector<std::int64_t> scale_particles(const Plan& plan);
/// 50 to 1080.
std::vector<int> scale_beams(const Plan& plan);
/// 1 to `all`: every number up to 4, then steps of about 1.4.
std::vector<int> scale_threads(int all, bool quick);

inline constexpr std::array<double, 3> kScaleBudgets_s{0.040, 0.010, 0.001};

/// Adds to `results`; on an interruption what is finished stays. What does not fit in memory is skipped, and
/// noted.
void measure_scale(const Plan& plan, const std::vector<Scene>& scenes, const Control& control,
                   Results& results);

}  // namespace parloc::tools::bench
