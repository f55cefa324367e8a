#include "tools/evaluate/relations_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace parloc::tools::evaluate {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr std::size_t kLargest = 10;

std::string mean_and_std(double mean_m, double std_m) {
  return fmt::format("{:.3f} +- {:.3f}", mean_m, std_m);
}

}  // namespace

Facts origin_facts(const RelationsReport& r) {
  const RelationErrors& e = r.errors;
  Facts lines{{"trajectory", fmt::format("{}, {} poses", r.trajectory_path, r.trajectory.size())},
              {"relations", fmt::format("{}, {} of {} have both poses in the trajectory", r.relations_path,
                                        e.compared, e.compared + e.without_pose)}};
  if (e.repeated_stamps > 0)
    lines.push_back(
        {"warning", fmt::format("{} the stamp of an earlier one, which is the one that counts",
                                e.repeated_stamps == 1 ? "1 pose has"
                                                       : fmt::format("{} poses have", e.repeated_stamps))});
  return lines;
}

Table error_table(const RelationsReport& r) {
  const RelationErrors& e = r.errors;
  Table table;
  table.title = "Relation error";
  table.columns = {{"", "", true}, {"", "mean"}, {"", "std"}, {"", "RMSE"}, {"", "median"}, {"", "max"}};
  const auto add = [&](const char* name, int decimals, double unit, const std::vector<double>& values) {
    std::vector<std::string> row{name};
    for (const double v : values) row.push_back(fmt::format("{:.{}f}", unit * v, decimals));
    table.rows.push_back(row);
  };
  add("translation [m]", 4, 1.0,
      {e.translation_mean_m, e.translation_std_m, e.translation_rmse_m, e.translation_median_m,
       e.translation_max_m});
  add("rotation [deg]", 2, kDegrees,
      {e.rotation_mean_rad, e.rotation_std_rad, e.rotation_rmse_rad, e.rotation_median_rad,
       e.rotation_max_rad});
  return table;
}

std::vector<const PublishedLog*> published_beside(const RelationsReport& r) {
  if (r.log != nullptr) return {r.log};
  std::vector<const PublishedLog*> all;
  for (const PublishedLog& log : kPublishedLogs) all.push_back(&log);
  return all;
}

Table published_table(const RelationsReport& r) {
  Table table;
  table.title = fmt::format("Published translation, mean +- std [m] ({})", kPublishedSource);
  table.columns = {{"", "log", true}};
  if (r.log != nullptr) table.columns.push_back({"", "this trajectory"});
  for (const char* method : kPublishedMethods) table.columns.push_back({"", method});
  for (const PublishedLog* log : published_beside(r)) {
    std::vector<std::string> row{log->name};
    if (r.log != nullptr)
      row.push_back(mean_and_std(r.errors.translation_mean_m, r.errors.translation_std_m));
    for (const PublishedError& error : log->errors) row.push_back(mean_and_std(error.mean_m, error.std_m));
    table.rows.push_back(row);
  }
  return table;
}

std::vector<RelationError> largest_errors(const RelationErrors& errors) {
  std::vector<RelationError> largest = errors.each;
  std::stable_sort(largest.begin(), largest.end(), [](const RelationError& a, const RelationError& b) {
    return a.translation_m > b.translation_m;
  });
  largest.resize(std::min(largest.size(), kLargest));
  return largest;
}

}  // namespace parloc::tools::evaluate
