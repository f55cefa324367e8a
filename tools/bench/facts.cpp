#include "tools/bench/facts.h"

#include <fmt/format.h>

#include "tools/bench/scenes.h"
#include "tools/report/machine/build_info.h"

namespace parloc::tools::bench {

std::vector<std::pair<std::string, std::string>> facts(const Results& r) {
  const std::string commit = kCommit[0] == '\0' ? "" : fmt::format(", commit {}", kCommit);
  std::vector<std::pair<std::string, std::string>> lines{
      {"machine", fmt::format("{}, {} core{}, {:.0f} GB, {}", r.machine.cpu, r.machine.cores,
                              r.machine.cores == 1 ? "" : "s",
                              1e-9 * static_cast<double>(r.machine.memory_bytes), r.machine.os)}};
  for (const std::string& device : r.machine.devices) lines.emplace_back("device", device);
  if (!r.machine.gpu_driver.empty()) lines.emplace_back("driver", r.machine.gpu_driver);
  lines.emplace_back("build",
                     fmt::format("parloc {}{}, {}, {}: {}", kVersion, commit, kCompiler, kBuildType, kFlags));
  if (r.machine.load_average >= 0.0)
    lines.emplace_back("load", fmt::format("{:.2f} in the minute before (other work makes times longer)",
                                           r.machine.load_average));
  for (const std::string& setting : r.machine.settings) lines.emplace_back("setting", setting);
  lines.emplace_back("sensor",
                     fmt::format("{:g} m, beams over {:g} degrees; Gaussian model, sigma 0.1 m, tempering 1",
                                 kRangeMax_m, kFieldOfView_deg));
  lines.emplace_back("inside",
                     "one whole filter step, from odometry and raw scan to the estimate, uploads and "
                     "downloads included");
  lines.emplace_back("times", fmt::format("medians of {} steps or more after a warm-up, about {:g} s per row",
                                          r.rules.least_steps, r.rules.seconds));
  if (!r.scale)
    lines.emplace_back(
        "marks",
        "* within 40 ms; ratio: time here over the published time; speed-up: over published on 1 "
        "thread, here; size: particles x beams");
  return lines;
}

std::vector<std::string> remarks(const Results& r) {
  std::vector<std::string> lines;
  if (r.interrupted) lines.push_back("interrupted: only what was finished by then is here");
  lines.insert(lines.end(), r.notes.begin(), r.notes.end());
  const std::vector<std::string> skipped = skipped_lines(r.skipped);
  lines.insert(lines.end(), skipped.begin(), skipped.end());
  return lines;
}

std::string heading(const Results& results, const Place& place) {
  for (const SceneFacts& scene : results.scenes) {
    if (scene.name == place.scene)
      return fmt::format("{}, cloud {} ({})", scene.name, place.cloud, scene.what);
  }
  return place.scene;
}

}  // namespace parloc::tools::bench
