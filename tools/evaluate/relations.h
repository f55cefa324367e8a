// A trajectory judged by relations, and the forms in which that is told.
#pragma once

#include <cstddef>
#include <string>

#include "common/eval/metrics.h"
#include "tools/evaluate/published_relations.h"

namespace parloc::tools::evaluate {

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

}  // namespace parloc::tools::evaluate
