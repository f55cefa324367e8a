#include "tools/bench/forms.h"

#include "common/config/config.h"
#include "common/filter/filter_settings.h"
#include "common/model/model_settings.h"
#include "tools/bench/published.h"
#include "tools/bench/steps/scenes.h"
#include "tools/report/result_parts.h"

namespace parloc::tools::bench {
namespace {

Json protocol_json(const Results& r) {
  return {{"inside_the_time",
           "one filter step: motion model, choice and upload of the beams, predict, weight, "
           "normalise_scan, estimate, resample, download of the estimate"},
          {"seconds_per_row", r.rules.seconds},
          {"least_steps", r.rules.least_steps},
          {"most_steps", r.rules.most_steps},
          {"warm_up_steps", r.rules.warm_up_steps},
          {"warm_up_seconds", r.rules.warm_up_seconds},
          {"range_max_m", kRangeMax_m},
          {"field_of_view_deg", kFieldOfView_deg},
          {"budget_s", kBudget_s}};
}

Json published_json() {
  Json tables = Json::array();
  for (const PublishedTable& t : published_tables()) {
    tables.push_back({{"key", t.key},
                      {"machine", t.machine},
                      {"particles", kPublishedParticles},
                      {"beams", kPublishedBeams},
                      {"seconds", t.seconds}});
  }
  return tables;
}

Json peers_json() {
  Json peers{{"machine", kPeerMachine},
             {"scene", kPeerScene},
             {"particles", kPeerParticles},
             {"beams", kPeerBeams},
             {"times", Json::array()}};
  for (const PeerTime& t : peer_times())
    peers["times"].push_back({{"program", t.program},
                              {"sensor_model", name_of(t.model, kSensorModels)},
                              {"threads", t.threads},
                              {"seconds", t.seconds}});
  return peers;
}

Json variants_json(const Results& r) {
  Json variants = Json::array();
  for (std::size_t v = 0; v < r.variants.size(); ++v) {
    const Variant& variant = r.variants[v];
    const FilterBackendConfig c = backend_config(variant, 1);
    const bool cuda = variant.backend == BackendChoice::cuda;
    variants.push_back(
        {{"name", name_of(variant)},
         {"algorithm", kAlgorithmNames[static_cast<std::size_t>(variant.algorithm)]},
         {"backend", cuda ? "cuda" : "cpu"},
         {"backend_name", text_or_null(r.backends[v])},
         {"threads", json_if(!cuda, variant.threads)},
         {"device", json_if(cuda, variant.device)},
         {"sensor_model", name_of(c.sensor.model, kSensorModels)},
         {"sigma_hit_m", c.sensor.sigma_hit},
         {"tempering", c.sensor.tempering},
         {"caster", name_of(c.sensor.caster, kRayCasters)},
         {"fixed_step_cells", json_if(c.sensor.caster == RayCaster::fixed_step, c.sensor.fixed_step_cells)},
         {"resampling", name_of(c.resample.scheme, kResampleSchemes)},
         {"resample_threshold", c.resample.threshold}});
  }
  return variants;
}

Json ratios_json(const Row& row) {
  Json ratios = Json::object();
  for (const PublishedTable& t : published_tables()) {
    const auto then_s = published_seconds(t, row.particles, row.beams);
    if (then_s) ratios[t.key] = row.time.median_s / *then_s;
  }
  return ratios;
}

Json stages_json(const Row& row) {
  Json stages = Json::object();
  const auto bytes = least_stage_bytes(row.particles, row.beams);
  double sum_s = 0.0;
  for (const double s : *row.stages) sum_s += s;
  for (std::size_t s = 0; s < kStageNames.size(); ++s) {
    const double stage_s = (*row.stages)[s];
    stages[kStageNames[s]] = {{"median_s", stage_s},
                              {"share", stage_s / sum_s},
                              {"least_bytes", bytes[s]},
                              {"least_bytes_per_s", bytes[s] / stage_s}};
  }
  return stages;
}

Json row_json(const Results& r, const Row& row) {
  const TimeSummary& t = row.time;
  Json json{{"sweep", kSweepNames[static_cast<int>(row.sweep)]},
            {"scene", row.place.scene},
            {"cloud", row.place.cloud},
            {"variant", name_of(r.variants[row.variant])},
            {"particles", row.particles},
            {"beams", row.beams},
            {"median_s", t.median_s},
            {"q1_s", t.q1_s},
            {"q3_s", t.q3_s},
            {"p99_s", t.p99_s},
            {"least_s", t.least_s},
            {"most_s", t.most_s},
            {"steps", t.count},
            {"rays_per_s", row.rays_per_s()},
            {"within_budget", t.median_s <= kBudget_s}};
  if (row.sweep == Sweep::tables) json["ratio"] = ratios_json(row);
  if (row.stages) json["stages"] = stages_json(row);
  return json;
}

Json largest_json(const Results& r, const Largest& l) {
  const bool any = l.particles > 0;
  return {{"scene", l.place.scene},
          {"cloud", l.place.cloud},
          {"variant", name_of(r.variants[l.variant])},
          {"beams", l.beams},
          {"budget_s", l.budget_s},
          {"particles", l.particles},
          {"too_many", json_if(l.too_many > 0, l.too_many)},
          {"limit", text_or_null(l.limit)},
          {"median_s", json_if(any, l.median_s)},
          {"p99_s", json_if(any, l.p99_s)}};
}

}  // namespace

std::string json_text(const Results& r) {
  Json json{{"tool", "parloc bench"},
            {"mode", r.scale ? "scale" : "tables"},
            {"quick", r.quick},
            {"interrupted", r.interrupted},
            {"command", r.command},
            {"date", r.date},
            {"machine", machine_json(r.machine)},
            {"build", build_json()},
            {"protocol", protocol_json(r)}};
  json["scenes"] = Json::array();
  for (const SceneFacts& s : r.scenes) json["scenes"].push_back({{"name", s.name}, {"what", s.what}});
  json["published"] = published_json();
  json["peers"] = peers_json();
  json["variants"] = variants_json(r);
  json["rows"] = Json::array();
  for (const Row& row : r.rows) json["rows"].push_back(row_json(r, row));
  json["largest"] = Json::array();
  for (const Largest& l : r.largest) json["largest"].push_back(largest_json(r, l));
  json["skipped"] = Json::array();
  for (const Skipped& s : r.skipped) json["skipped"].push_back({{"what", s.what}, {"why", s.why}});
  json["notes"] = r.notes;
  // A file name in `command` may hold any bytes.
  return file_text(json);
}

}  // namespace parloc::tools::bench
