// Trials at once on a GPU, whose filters step together, find what they find one after the other on the CPU.
#include <gtest/gtest.h>

#include "common/map/map_reader.h"
#include "tests/unit/without_gpu.h"
#include "tools/evaluate/trials.h"

namespace parloc {
namespace {

std::vector<TrialResult> trials(BackendChoice backend, int jobs) {
  const Scenario scenario = read_scenario("configs/paz2012_scenario.yaml");
  const GridMap map = read_map(scenario.map_path);
  TrialPlan plan;
  plan.task = TrialTask::track;
  plan.duration_s = 1.0;
  tools::evaluate::TrialsRequest request;
  request.plan = plan;
  request.items = {0, 1, 2};
  request.samples = true;
  request.jobs = jobs;
  request.config.backend = backend;
  request.config.particles = 200;
  request.config.scan.max_beams = 30;
  return run_trials(request, tools::evaluate::simulated_trials(plan, scenario, map, "hall"),
                    read_map(scenario.localization_map_path));
}

TEST(GroupTrials, GpuTrialsAtOnceAreThoseOfTheCpu) {
  std::vector<TrialResult> gpu;
  PARLOC_NEEDS_GPU(gpu = trials(BackendChoice::cuda, 3));
  const std::vector<TrialResult> cpu = trials(BackendChoice::cpu, 1);
  ASSERT_EQ(gpu.size(), cpu.size());
  for (std::size_t k = 0; k < cpu.size(); ++k) {
    ASSERT_EQ(gpu[k].samples.size(), cpu[k].samples.size());
    ASSERT_GT(cpu[k].samples.size(), 3u);
    for (std::size_t i = 0; i < cpu[k].samples.size(); ++i) {
      EXPECT_EQ(gpu[k].samples[i].position_error_m, cpu[k].samples[i].position_error_m);
      EXPECT_EQ(gpu[k].samples[i].log_odds, cpu[k].samples[i].log_odds);
    }
  }
}

}  // namespace
}  // namespace parloc
