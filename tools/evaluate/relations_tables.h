// What terminal, JSON and page of a trajectory judged by relations have in common.
#pragma once

#include <vector>

#include "tools/evaluate/relations.h"
#include "tools/report/text/facts.h"
#include "tools/report/text/table.h"

namespace parloc::tools::evaluate {

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
