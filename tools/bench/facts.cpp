#include "tools/bench/facts.h"

#include <fmt/format.h>

#include "tools/bench/steps/scenes.h"
#include "tools/report/machine/build_info.h"

namespace parloc::tools::bench {

Facts facts(const Results& r) {
  Facts lines{{"machine", fmt::format("{}, {} core{}, {:.0f} GB, {}", r.machine.cpu, r.machine.cores,
                                      r.machine.cores == 1 ? "" : "s",
                                      1e-9 * static_cast<double>(r.machine.memory_bytes), r.machine.os)}};
  for (const std::string& device : r.machine.devices) lines.push_back({"device", device});
  if (!r.machine.gpu_driver.empty()) lines.push_back({"driver", r.machine.gpu_driver});
  lines.push_back({"build", fmt::format("{}, {}, {}: {}", version_text(), kCompiler, kBuildType, kFlags)});
  if (r.machine.load_average >= 0.0)
    lines.push_back({"load", fmt::format("{:.2f} in the minute before (other work makes times longer)",
                                         r.machine.load_average)});
  for (const std::string& setting : r.machine.settings) lines.push_back({"setting", setting});
  lines.push_back(
      {"sensor", fmt::format("{:g} m, beams over {:g} degrees; Gaussian model, sigma 0.1 m, tempering 1",
                             kRangeMax_m, kFieldOfView_deg)});
  lines.push_back({"inside",
                   "one whole filter step, from odometry and raw scan to the estimate, uploads and "
                   "downloads included"});
  lines.push_back({"times", fmt::format("medians of {} steps or more after a warm-up, about {:g} s per row",
                                        r.rules.least_steps, r.rules.seconds)});
  if (!r.scale)
    lines.push_back({"marks",
                     "* within 40 ms; ratio: time here over the published time; speed-up: over paz2012 on 1 "
                     "thread, here; size: particles x beams"});
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
