// A trajectory judged by relations, beside what Kuemmerle et al. 2009 published, and the forms in which that
// is told.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "common/eval/metrics.h"
#include "tools/report/text/table.h"

namespace parloc::tools::evaluate {

/// Of the translation, over all relations of a log [m].
struct PublishedError {
  double mean_m, std_m;
};

inline constexpr std::array<const char*, 3> kPublishedMethods{"scan matching", "RBPF, 50 particles",
                                                              "graph mapping"};

struct PublishedLog {
  const char* name;  ///< For the command line.
  std::array<PublishedError, kPublishedMethods.size()> errors;
};

/// "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27 (2009). The figures are taken from
/// two tabulations by others, which agree; they have not been checked against the paper itself.
inline constexpr const char* kPublishedSource = "Kuemmerle et al. 2009, as tabulated by others";

inline constexpr std::array<PublishedLog, 6> kPublishedLogs{{
    {"aces", {{{.173, .614}, {.060, .049}, {.044, .044}}}},
    {"intel", {{{.220, .296}, {.070, .083}, {.031, .026}}}},
    {"mit_killian", {{{1.651, 4.138}, {.122, .386}, {.050, .056}}}},
    {"mit_csail", {{{.106, .325}, {.049, .049}, {.004, .009}}}},
    {"freiburg_079", {{{.258, .427}, {.061, .044}, {.056, .042}}}},
    {"freiburg_hospital", {{{.434, 1.615}, {.637, 2.638}, {.143, .180}}}},
}};

/// Throws Error{usage} that names all of them.
const PublishedLog& published_log(const std::string& name);

struct RelationsReport {
  std::string command, date;  ///< As typed; UTC.
  std::string trajectory_path, relations_path;
  const PublishedLog* log = nullptr;  ///< Whose relations these are; null: not said.
  Trajectory trajectory;
  RelationErrors errors;  ///< Of one relation at least.
};

/// Reads both files and compares them. Throws Error{input}, also if no relation has both its poses.
RelationsReport judge_by_relations(const std::string& trajectory_path, const std::string& relations_path);

std::string terminal_text(const RelationsReport& r);
/// The same report gives the same bytes, but for command and build.
std::string json_text(const RelationsReport& r);
std::string html_page(const RelationsReport& r);

/// What was compared, and what is odd about it.
Facts origin_facts(const RelationsReport& r);
/// Mean, standard deviation, RMSE, median and largest, of translation and rotation.
Table error_table(const RelationsReport& r);
/// The published logs that belong beside it: its own, or all if that is not said.
std::vector<const PublishedLog*> published_beside(const RelationsReport& r);
Table published_table(const RelationsReport& r);
/// By translation, at most ten; the largest first.
std::vector<RelationError> largest_errors(const RelationErrors& errors);

}  // namespace parloc::tools::evaluate
