// Any text is a scan file whose values can be computed with, or an Error{input} of one line; and where it was
// taken can be searched for.
#include <cmath>

#include "common/io/scan_file.h"
#include "common/search/global_search.h"
#include "tests/fuzz/one_line.h"

namespace {

using parloc::fuzz::require;

parloc::GlobalSearch small_search() {
  parloc::SearchConfig config;
  config.beams = 16, config.max_headings = 72, config.candidates = 4, config.most = 4;
  return parloc::GlobalSearch(
      parloc::grid_from_text(
          {"##########", "#........#", "#......###", "###..##..#", "#........#", "##########"}, 0.25),
      config, {.backend = parloc::BackendChoice::cpu, .threads = 1});
}

void search(const parloc::Scan& scan) {
  static parloc::GlobalSearch search = small_search();
  for (const parloc::Hypothesis& h : search.search(scan, parloc::StepConfig{}).hypotheses) {
    require(std::isfinite(h.pose.x_m) && std::isfinite(h.pose.y_m) && std::fabs(h.pose.theta_rad) < 3.2);
    require(std::isfinite(h.evidence) && h.score >= 0.0 && h.score <= 1.0);
    require(h.weight >= 0.0 && h.weight <= 1.0 && h.explained + h.through + h.unmapped < 1.001);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::reads_or_says_why(parloc::ErrorKind::input, [&] {
    const parloc::Scan scan = parloc::scan_from_text(parloc::fuzz::text_of(data, size), "fuzz");
    require(!scan.ranges_m.empty() && scan.ranges_m.size() <= size);
    require(std::isfinite(scan.T_base_sensor.x_m) && std::isfinite(scan.T_base_sensor.y_m) &&
            std::fabs(scan.T_base_sensor.theta_rad) < 3.2);
    require(std::isfinite(scan.stamp_s) && std::fabs(scan.angle_min_rad) < 13.0 &&
            std::fabs(scan.angle_step_rad) < 6.3);
    search(scan);
  });
  return 0;
}
