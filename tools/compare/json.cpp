
#include "common/config/config.h"
#include "tools/compare/comparison.h"
#include "tools/report/result_parts.h"

namespace parloc::tools::compare {
namespace {

Json pair_json(const MeanDeviation& v) {
  return {{"mean", v.mean}, {"deviation", v.deviation}};
}

Json plan_json(const Comparison& c) {
  const StartPlan& s = c.request.start;
  Json json{{"source", c.source},
            {"map", c.map_path},
            {"first_seed", c.request.first_seed},
            {"seeds", c.request.seeds},
            {"duration_s", json_if(c.plan.duration_s > 0.0, c.plan.duration_s)},
            {"start_sigma_m", s.sigma_xy_m},
            {"start_sigma_rad", s.sigma_theta_rad},
            {"start_off_m", s.off_m},
            {"start_off_rad", s.off_rad},
            {"kidnapping", nullptr},
            {"unmapped_hits", static_cast<double>(c.outcome.unmapped) / static_cast<double>(c.outcome.hits)},
            {"lost_m", kLost_m}};
  if (c.plan.kidnapping)
    json["kidnapping"] = {{"after_s", c.plan.kidnapping->after_s},
                          {"until_s", c.plan.kidnapping->until_s},
                          {"distance_m", c.plan.kidnapping->distance_m}};
  return json;
}

Json published_json(const PublishedSetting* setting) {
  if (setting == nullptr) return nullptr;
  Json rows = Json::array();
  for (const PublishedRow& r : setting->rows)
    rows.push_back({{"name", r.name},
                    {"filter", r.kind},
                    {"particles", r.particles},
                    {"position_rmse_m", r.position_rmse_m},
                    {"position_mae_m", json_of(r.position_mae_m)},
                    {"heading_rmse_rad", r.heading_rmse_rad},
                    {"heading_mae_rad", json_of(r.heading_mae_rad)},
                    {"step_ms", json_of(r.step_ms)}});
  return {{"source", setting->source},
          {"kappa_m", setting->kappa_m},
          {"sigma_range_m", setting->sigma_range_m},
          {"resolution_m", setting->resolution_m},
          {"rows", rows}};
}

Json run_json(const Comparison& c, const FilterRun& r) {
  const TrackErrors& e = r.errors;
  const auto& kidnapping = c.plan.kidnapping;
  return {{"seed", r.seed},
          {"kidnapped_s", kidnapping ? Json(kidnapped_after_s(*kidnapping, r.seed)) : Json(nullptr)},
          {"scans", r.scans},
          {"compared", e.compared},
          {"skipped", r.skipped},
          {"position_rmse_m", e.position_rmse_m},
          {"position_mae_m", e.position_mae_m},
          {"position_max_m", e.position_max_m},
          {"heading_rmse_rad", e.heading_rmse_rad},
          {"heading_mae_rad", e.heading_mae_rad},
          {"heading_max_rad", e.heading_max_rad},
          {"nees", r.nees},
          {"final_m", r.final_m},
          {"lost", r.lost()},
          {"lost_s", json_of(r.lost_s)},
          {"found_s", json_of(r.found_s)},
          {"away", r.away},
          {"particles", r.particles}};
}

Json filter_json(const Comparison& c, std::size_t k) {
  const Entry& e = c.request.entries[k];
  const Summary& s = c.summaries[k];
  Json json{{"filter", e.label},
            {"kind", e.kind},
            {"runs", s.runs},
            {"lost", s.lost},
            {"kept", s.runs - s.lost},  // in the means of errors
            {"lost_s", pair_json(s.lost_s)},
            {"away", s.away},
            {"particles", s.particles},
            {"skipped", s.skipped},
            {"position_rmse_m", pair_json(s.position_rmse_m)},
            {"position_mae_m", pair_json(s.position_mae_m)},
            {"position_max_m", pair_json(s.position_max_m)},
            {"heading_rmse_rad", pair_json(s.heading_rmse_rad)},
            {"heading_mae_rad", pair_json(s.heading_mae_rad)},
            {"heading_max_rad", pair_json(s.heading_max_rad)},
            {"nees", pair_json(s.nees)},
            {"config", config_to_yaml(e.config)},
            {"each", Json::array()}};
  for (const FilterRun& r : c.outcome.runs[k]) json["each"].push_back(run_json(c, r));
  return json;
}

Json times_json(const Comparison& c) {
  Json json{{"date", c.date},
            {"wall_s", c.wall_s},
            {"jobs", json_if(c.shards == 0, c.request.jobs)},
            {"shards", json_if(c.shards > 0, c.shards)},
            {"machine", machine_json(c.machine)},
            {"filters", Json::array()}};
  for (std::size_t k = 0; k < c.summaries.size(); ++k) {
    const Summary& s = c.summaries[k];
    const bool timed = s.step.count > 0;
    json["filters"].push_back({{"filter", c.request.entries[k].label},
                               {"backend", c.outcome.backends[k]},
                               {"steps", s.step.count},
                               {"step_median_ms", json_if(timed, 1e3 * s.step.median_s)},
                               {"step_p99_ms", json_if(timed, 1e3 * s.step.p99_s)},
                               {"real_time_factor", s.real_time_factor}});
  }
  return json;
}

}  // namespace

std::string json_text(const Comparison& c) {
  Json json{{"tool", "parloc compare"}, {"command", c.command}, {"interrupted", c.interrupted}};
  json["build"] = build_json();
  json["plan"] = plan_json(c);
  json["published"] = published_json(c.published);
  json["filters"] = Json::array();
  for (std::size_t k = 0; k < c.summaries.size(); ++k) json["filters"].push_back(filter_json(c, k));
  json["times"] = times_json(c);
  return file_text(json);
}

}  // namespace parloc::tools::compare
