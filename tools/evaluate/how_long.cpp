#include "tools/evaluate/how_long.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "tools/report/text/numbers.h"

namespace parloc::tools::evaluate {
namespace {

constexpr std::array<std::size_t, 5> kCores{1, 2, 16, 64, 1000};

std::string number_text(std::size_t number) {
  return grouped(static_cast<std::int64_t>(number));
}

}  // namespace

double work_s(std::size_t trials, double trial_s, std::size_t cores) {
  return static_cast<double>((trials + cores - 1) / cores) * trial_s;
}

std::string duration_text(double seconds) {
  constexpr double kMinute = 60.0, kHour = 3600.0, kDay = 86400.0;
  const auto in = [&](double unit, const char* name) {
    return fmt::format("{} {}", significant(seconds / unit, 2), name);
  };
  if (!std::isfinite(seconds)) return "-";
  if (seconds < 1.0) return in(1e-3, "ms");
  if (seconds < 2.0 * kMinute) return in(1.0, "s");
  if (seconds < 2.0 * kHour) return in(kMinute, "min");
  return seconds < 2.0 * kDay ? in(kHour, "h") : in(kDay, "days");
}

std::string how_long_text(std::size_t trials, double trial_s, std::size_t cores_here) {
  std::string text =
      fmt::format("{} on {} core{} as here", duration_text(work_s(trials, trial_s, cores_here)), cores_here,
                  cores_here == 1 ? "" : "s");
  for (const std::size_t cores : kCores)
    if (cores > cores_here)
      text += fmt::format(", {} on {}", duration_text(work_s(trials, trial_s, cores)), number_text(cores));
  return text;
}

Table how_long_table(std::size_t trials, double trial_s) {
  Table table;
  table.title = "Times of more trials, by the mean time of those above";
  table.columns = {{"", "trials"}};
  for (const std::size_t cores : kCores)
    table.columns.push_back({"", fmt::format("{} core{}", number_text(cores), cores == 1 ? "" : "s")});
  for (const std::size_t n : std::set<std::size_t>{trials, 1000, 10000, 100000, 1000000}) {
    table.rows.push_back({number_text(n)});
    for (const std::size_t cores : kCores)
      table.rows.back().push_back(duration_text(work_s(n, trial_s, cores)));
  }
  return table;
}

}  // namespace parloc::tools::evaluate
