// What the user wants to be measured, and the two ways of measuring it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/bench/results.h"
#include "tools/bench/steps/measure.h"
#include "tools/bench/steps/scenes.h"
#include "tools/bench/steps/variants.h"

namespace parloc::tools::bench {

struct Plan {
  std::vector<std::string> scenes;
  std::vector<Cloud> clouds;
  std::vector<Algorithm> algorithms;
  int threads = 0;  ///< 0: all cores.
  std::int64_t max_particles = 0;
  int max_beams = 0;
  bool quick = false;
};

/// The variants of one size are measured one right after the other, since their ratios are what counts. Adds
/// to `results`; on an interruption what is finished stays.
void measure_tables(const Plan& plan, const std::vector<Scene>& scenes, const Control& control,
                    Results& results);

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
