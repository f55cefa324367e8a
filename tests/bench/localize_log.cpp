// The closed loop over a log and nothing else: what Python's costs are compared with
// (tools/studies/python_cost.py). Usage: localize_log MAP LOG X Y THETA PARTICLES        prints scans,
// seconds of processor time of the loop, digest
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <vector>

#include "common/error.h"
#include "common/inputs/open_log.h"
#include "common/io/scan_stream.h"
#include "common/localize/localizer.h"
#include "common/map/map_reader.h"

namespace {

using namespace parloc;

int localize(char** arguments) {
  LocalizerConfig config;
  config.threads = 1;
  config.particles = std::atol(arguments[6]);
  const GridMap map = read_map(arguments[1]);
  Localizer localizer(config, map);
  localizer.start_at({std::atof(arguments[3]), std::atof(arguments[4]), std::atof(arguments[5])},
                     config.initial_sigma_xy, config.initial_sigma_xy, config.initial_sigma_theta);
  const std::clock_t begun = std::clock();
  const auto log = open_log(arguments[2]);
  ScanStream scans(*log, config.scan, config.lidars, [](std::size_t) {});
  std::vector<LocalizerEstimate> estimates;
  for (LogRecord record; scans.next(record);) {
    scans.pass_odometry([&](const StampedPose& r) { localizer.add_odometry(r.stamp_s, r.pose); });
    estimates.push_back(localizer.step(record.odometry, record.scan));
  }
  const double took_s = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  fmt::print("{} {:.4f} {}\n", estimates.size(), took_s, localizer.filter().digest());
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 7) {
    fmt::print(stderr, "usage: localize_log MAP LOG X Y THETA PARTICLES\n");
    return 2;
  }
  try {
    return localize(arguments);
  } catch (const Error& e) {
    fmt::print(stderr, "localize_log: {}\n", e.what());
    return static_cast<int>(e.kind());
  }
}
