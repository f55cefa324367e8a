// What the kernels of one scan of grid SLAM do, counted on PTX: for the model of its time
// (tools/studies/gpu_model.py).
//   count_slam LOG PROPOSAL PARTICLES SCANS [COUNTED]
// So many scans of the log are taken in; of the last COUNTED of them (1 if not given), each counted for
// itself, prints JSON in a list.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "common/error.h"
#include "common/io/log.h"
#include "common/slam/grid_slam.h"
#include "tests/ptx/counted.h"

namespace {

using namespace parloc;

SlamProposal proposal_named(const std::string& name) {
  if (name == "scan_match") return SlamProposal::scan_match;
  if (name == "gaussian") return SlamProposal::gaussian;
  throw Error(ErrorKind::usage, "no proposal '" + name + "'");
}

nlohmann::json count(const std::string& path, SlamProposal proposal, int particles, std::size_t scans,
                     std::size_t counted) {
  GridSlamConfig config;
  config.backend = BackendChoice::cuda;
  config.slam.particles = particles;
  config.slam.proposal = proposal;
  config.slam.close_loops = false;
  GridSlam slam(config);
  nlohmann::json list;
  const auto log = open_carmen_log(path);
  for (LogRecord r; slam.records().size() < scans && log->next(r);) {
    if (r.kind != RecordKind::scan) continue;
    ptx::forget_counts();
    if (!slam.step(r.odometry, r.scan) || slam.records().size() + counted <= scans) continue;
    list.push_back(test::counted());
    const SlamRecord& now = slam.records().back();
    list.back().update({{"resampled", now.resampled}, {"tiles", now.tiles}});
  }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    fmt::print(stderr, "usage: count_slam LOG PROPOSAL PARTICLES SCANS [COUNTED]\n");
    return 2;
  }
  try {
    const auto number = [&](int k) { return static_cast<std::size_t>(std::atoll(argv[k])); };
    fmt::print("{}\n", count(argv[1], proposal_named(argv[2]), std::atoi(argv[3]), number(4),
                             argc > 5 ? number(5) : 1)
                           .dump(1));
  } catch (const Error& error) {
    fmt::print(stderr, "count_slam: {}\n", error.what());
    return static_cast<int>(error.kind());
  }
}
