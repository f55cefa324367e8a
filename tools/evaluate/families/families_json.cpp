#include <nlohmann/json.hpp>
#include <optional>

#include "tools/evaluate/families/families_report.h"
#include "tools/report/result_parts.h"

namespace parloc::tools::families {
namespace {

Json rate_json(const Rate& r) {
  return {{"hits", r.hits}, {"of", r.trials}, {"share", r.share}, {"low", r.low}, {"high", r.high}};
}
Json spread_json(const Spread& s) {
  return {{"count", s.count}, {"median", s.median}, {"p95", s.p95}, {"most", s.most}};
}
Json seconds_or_null(const std::optional<double>& seconds) {
  return seconds ? Json(*seconds) : Json(nullptr);
}
Json states_json(const std::array<double, 3>& by_state) {
  Json json;
  for (const HealthState state : {HealthState::tracking, HealthState::ambiguous, HealthState::lost})
    json[parloc::name_of(state)] = by_state[static_cast<std::size_t>(state)];
  return json;
}

Json calibration_json(const RunsSummary& r) {
  Json bins = Json::array();
  for (const ReliabilityBin& b : r.calibration.bins)
    bins.push_back({{"count", b.count}, {"forecast_mean", b.forecast_mean}, {"observed", b.observed}});
  return {{"count", r.calibration.count}, {"right", r.calibration.came_true}, {"brier", r.calibration.brier},
          {"auc", r.calibration.auc},     {"error", r.calibration_error},     {"bins", bins}};
}

Json runs_json(const RunsSummary& r) {
  return {{"nearly_all_within", rate_json(r.nearly_all_within)},
          {"all_within", rate_json(r.all_within)},
          {"within", r.within},
          {"rmse_m", spread_json(r.rmse_m)},
          {"largest_m", r.largest_m},
          {"states", states_json(r.by_state)},
          {"sure_wrong", r.sure_wrong},
          {"sure_wrong_1s", rate_json(r.sure_wrong_1s)},
          {"late_sure_wrong", r.late_sure_wrong},
          {"nees",
           {{"drives", r.nees.count},
            {"mean", r.nees.mean},
            {"low", r.nees.low},
            {"high", r.nees.high},
            {"median", r.nees_median}}},
          {"last_x_error_rms_m", r.x_error_m},
          {"last_sigma_x_rms_m", r.sigma_x_m},
          {"localized_5s", rate_json(r.localized_5s)},
          {"noticed_2s", rate_json(r.noticed_2s)},
          {"searches", r.searches},
          {"calibration", calibration_json(r)}};
}

Json family_json(const FamilySummary& s) {
  return {{"family", s.family},          {"drives", s.drives},        {"scans", s.scans},
          {"driven_s", s.driven_s},      {"kept", rate_json(s.kept)}, {"failed", s.failed},
          {"loop", runs_json(s.closed)}, {"bare", runs_json(s.bare)}};
}

Json score_json(const RunScore& r) {
  return {{"samples", r.samples},
          {"rmse_m", r.rmse_m},
          {"largest_m", r.largest_m},
          {"largest_rad", r.largest_rad},
          {"within", r.within},
          {"states", states_json(r.by_state)},
          {"sure_wrong_s", r.sure_wrong_s},
          {"longest_sure_wrong_s", r.longest_sure_wrong_s},
          {"late_sure_wrong", static_cast<double>(r.late_sure_wrong) / static_cast<double>(r.late)},
          {"nees_mean", r.nees_mean},
          {"last_x_error_m", r.last_x_error_m},
          {"last_sigma_x_m", r.last_sigma_x_m},
          {"searches", r.searches},
          {"localized_after_s", seconds_or_null(r.localized_after_s)},
          {"noticed_after_s", seconds_or_null(r.noticed_after_s)}};
}

Json drive_json(const DriveResult& d) {
  Json parameters = Json::object();
  for (const auto& [name, value] : d.parameters) parameters[name] = value;
  return {{"family", d.family},
          {"seed", d.seed},
          {"place", d.place},
          {"driven_s", d.driven_s},
          {"events", d.events},
          {"bare_within", d.comparison.applies},
          {"no_worse", d.comparison.applies ? Json(d.comparison.kept) : Json(nullptr)},
          {"loop", score_json(d.closed_score)},
          {"bare", score_json(d.bare_score)},
          {"parameters", parameters}};
}

}  // namespace

void write_json(const FamiliesReport& report, const TextSink& sink) {
  Json json{{"tool", "parloc evaluate --families"},
            {"command", report.command},
            {"interrupted", report.interrupted}};
  json["build"] = build_json();
  json["plan"] = {
      {"source", report.source}, {"first_seed", report.first_seed}, {"drives_wanted", report.wanted}};
  json["config"] = config_to_yaml(report.config);
  json["all"] = family_json(report.all);
  json["families"] = Json::array();
  for (const FamilySummary& family : report.families) json["families"].push_back(family_json(family));
  json["times"] = {{"wall_s", report.wall_s},
                   {"jobs", json_if(report.shards == 0, report.jobs)},
                   {"shards", json_if(report.shards > 0, report.shards)},
                   {"date", report.date},
                   {"machine", machine_json(report.machine)}};
  const auto rows = [&](const RowSink& row) {
    report.drives.each([&](const DriveResult& drive) { row(drive_json(drive)); });
  };
  tools::write_json(json, "drives", rows, sink);
}

}  // namespace parloc::tools::families
