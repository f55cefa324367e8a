#include "tools/evaluate/evaluate_relations.h"

#include <fmt/format.h>

#include <cstdio>

#include "common/file/output_file.h"
#include "tools/evaluate/relations.h"
#include "tools/program/output_folder.h"
#include "tools/report/machine/machine.h"

namespace parloc::tools {
namespace {
constexpr const char *kJson = "relations.json", *kPage = "report.html";
}

int evaluate_relations(const RelationsOptions& o, const std::string& typed) {
  const evaluate::PublishedLog* log = o.dataset.empty() ? nullptr : &evaluate::published_log(o.dataset);
  evaluate::RelationsReport report = evaluate::judge_by_relations(o.trajectory, o.relations);
  report.command = typed;
  report.date = date_now();
  report.log = log;
  const std::string json = evaluate::json_text(report);
  if (!o.out.empty()) {
    OutputFolder out(o.out, {kJson, kPage});
    replace_file(out.staged(kJson), json);
    replace_file(out.staged(kPage), evaluate::html_page(report));
    out.publish();
  }
  if (o.json) {
    std::fputs(json.c_str(), stdout);
  } else if (!o.quiet) {
    fmt::print("{}", evaluate::terminal_text(report));
    if (!o.out.empty()) fmt::print("\n{:<18}{}/{} (beside it: {})\n", "report", o.out, kPage, kJson);
  }
  return 0;
}

}  // namespace parloc::tools
