
#include "common/config/config.h"
#include "tools/evaluate/evaluation.h"
#include "tools/report/result_parts.h"

namespace parloc::tools::evaluate {
namespace {

Json rate_json(const Rate& r) {
  return {{"hits", r.hits}, {"of", r.trials}, {"share", r.share}, {"low", r.low}, {"high", r.high}};
}
Json spread_json(const Spread& s) {
  return {{"count", s.count}, {"median", s.median}, {"p95", s.p95}, {"most", s.most}};
}

Json plan_json(const Evaluation& e) {
  const TrialPlan& p = e.plan;
  return {{"task", name_of(p.task)},
          {"recorded", e.recorded},
          {"source", e.source},
          {"map", e.map_path},
          {"first_seed", e.first_seed},
          {"trials_wanted", e.wanted},
          {"duration_s", json_if(p.duration_s > 0.0, p.duration_s)},
          {"limit_s", e.limit_s},
          {"hold_s", p.hold_s},
          {"grace_s", p.grace_s},
          {"near_m", p.near_m},
          {"near_rad", p.near_rad},
          {"speed_mps", json_if(!e.recorded, p.speed_mps)},
          {"turn_rate_rad_s", json_if(!e.recorded, p.turn_rate_rad_s)}};
}

Json calibration_json(const Calibration& c) {
  Json bins = Json::array();
  for (const ReliabilityBin& b : c.bins)
    bins.push_back({{"count", b.count}, {"forecast_mean", b.forecast_mean}, {"observed", b.observed}});
  return {{"count", c.count}, {"right", c.came_true}, {"brier", c.brier}, {"auc", c.auc}, {"bins", bins}};
}

Json summary_json(const Evaluation& e) {
  const TrialSummary& s = e.summary;
  Json json{{"trials", s.trials},
            {"unmapped", s.unmapped},
            {"success", rate_json(s.success)},
            {"localized", rate_json(s.localized)},
            {"right_after", rate_json(s.right_after)},
            {"localize_s", spread_json(s.localize_s)}};
  if (e.plan.task == TrialTask::kidnap) {
    json["tracked_before"] = rate_json(s.tracked_before);
    json["noticed"] = rate_json(s.noticed);
    json["notice_s"] = spread_json(s.notice_s);
  }
  json["confident_wrong"] = rate_json(s.confident_wrong);
  json["confident_wrong_1s"] = rate_json(s.confident_wrong_1s);
  json["driven_s"] = s.driven_s;
  json["right_s"] = s.right_s;
  json["wrong_s"] = s.wrong_s;
  json["false_lost"] = s.false_lost;
  json["false_lost_per_hour"] = s.false_lost_per_hour;
  json["missed_lost"] = s.missed_lost;
  json["rmse_m"] = s.rmse_m;
  json["nees"] = {
      {"trials", s.nees.count}, {"mean", s.nees.mean}, {"low", s.nees.low}, {"high", s.nees.high}};
  json["calibration"] = calibration_json(s.calibration);
  json["searches_mean"] = s.searches_mean;
  json["searches_most"] = s.searches_most;
  json["failed"] = s.failed;
  return json;
}

Json trial_json(const Evaluation& e, const TrialResult& t) {
  const TrialOutcome& o = t.outcome;
  const auto since = static_cast<double>(o.since_localized);
  Json json{{"seed", t.seed},
            {"begun_s", t.begun_s},
            {"start", {t.start.x_m, t.start.y_m, t.start.theta_rad}},
            {"success", succeeded(o, e.limit_s)},
            {"localized_after_s", json_of(o.localized_after_s)}};
  if (e.plan.task == TrialTask::kidnap) {
    json["tracked_before"] = o.tracked_before;
    json["noticed_after_s"] = json_of(o.noticed_after_s);
  }
  json["samples"] = o.samples;
  json["right"] = o.right;
  json["wrong_since"] = o.wrong_since;
  json["confident_wrong"] = o.confident_wrong;
  json["confident_wrong_s"] = o.confident_wrong_s;
  json["false_lost"] = o.false_lost;
  json["right_s"] = o.right_s;
  json["wrong_s"] = o.wrong_s;
  json["missed_lost_s"] = o.missed_lost_s;
  json["mean_squared_error_m2"] = o.squared_error_m2 / since;  // NaN, which JSON has as null, if never
  json["nees_mean"] = o.nees_sum / static_cast<double>(o.nees_count);
  json["searches"] = t.searches;
  return json;
}

Json times_json(const Evaluation& e) {
  Json json{{"step_ms", spread_json(e.summary.step_ms)},
            {"search_step_ms", spread_json(e.summary.search_ms)},
            {"wall_s", e.wall_s},
            {"trial_s", e.trial_s},
            {"jobs", json_if(e.shards == 0, e.jobs)},
            {"shards", json_if(e.shards > 0, e.shards)},
            {"date", e.date},
            {"machine", machine_json(e.machine)}};
  if (e.answer) json["dropped"] = e.dropped;
  return json;
}

}  // namespace

void write_json(const Evaluation& e, const TextSink& sink) {
  Json json{{"tool", "parloc evaluate"}, {"command", e.command}, {"interrupted", e.interrupted}};
  json["build"] = build_json();
  json["plan"] = plan_json(e);
  json["config"] = config_to_yaml(e.config);
  if (e.answer) json["answer"] = e.answer->json();
  json["summary"] = summary_json(e);
  json["times"] = times_json(e);
  const auto rows = [&](const RowSink& row) {
    e.trials.each([&](const TrialResult& t) { row(trial_json(e, t)); });
  };
  tools::write_json(json, "trials", rows, sink);
}

}  // namespace parloc::tools::evaluate
