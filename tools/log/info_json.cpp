#include <nlohmann/json.hpp>
#include <string>

#include "common/io/log_notes.h"
#include "tools/log/info_text.h"

namespace parloc::tools {

namespace {

using Json = nlohmann::ordered_json;

Json times_json(const StampSurvey& stamps) {
  const auto period_s = stamps.period_s(), mean_hz = stamps.mean_rate_hz();
  return {{"count", stamps.count()},
          {"first_s", stamps.first_s()},
          {"last_s", stamps.last_s()},
          {"mean_rate_hz", mean_hz ? Json(*mean_hz) : Json()},
          {"median_rate_hz", period_s ? Json(1.0 / *period_s) : Json()},
          {"longest_gap_s", stamps.longest_gap().length_s},
          {"stamps_backward", stamps.backward()},
          {"stamps_repeated", stamps.repeated()}};
}

Json scans_json(const ScanSurvey& s) {
  Json json = times_json(s.stamps);
  for (const auto& [beams, scans] : s.scans_of_beams) json["scans_of_beams"][std::to_string(beams)] = scans;
  json["first_bearing_rad"] = s.first_bearing_rad;
  json["last_bearing_rad"] = s.last_bearing_rad;
  json["range_min_m"] = s.range_min_m;
  json["range_max_m"] = s.range_max_m;
  json["scan_time_s"] = s.scan_time_s;
  json["nearest_m"] = s.nearest_m;
  json["farthest_m"] = s.farthest_m;
  json["readings"] = {{"good", s.good},        {"zero", s.zero},         {"inf", s.infinite},
                      {"nan", s.not_a_number}, {"negative", s.negative}, {"at_maximum", s.far}};
  json["mount"] = {{"x_m", s.T_base_sensor.x_m},
                   {"y_m", s.T_base_sensor.y_m},
                   {"yaw_rad", s.T_base_sensor.theta_rad},
                   {"upside_down", s.upside_down},
                   {"moves", s.mount_moves}};
  return json;
}

Json odometry_json(const OdometrySurvey& o) {
  Json json = times_json(o.stamps);
  json["alone"] = o.alone;
  json["length_m"] = o.length_m;
  json["turned_rad"] = o.turned_rad;
  json["max_speed_mps"] = o.max_speed_mps;
  json["max_turn_rate_rad_s"] = o.max_turn_rate_rad_s;
  json["standing_s"] = o.standing_s;
  json["standing_noise_m"] = o.standing_noise_m;
  json["standing_noise_rad"] = o.standing_noise_rad;
  return json;
}

}  // namespace

std::string info_json(const LogInfo& info) {
  Json json = {{"log", info.path}, {"format", info.bag ? info.bag->container : "carmen"}};
  if (info.bag) {
    for (const TopicSurvey& t : info.bag->topics) {
      Json topic = {{"name", t.topic.name}, {"type", t.topic.type}, {"bytes", t.bytes}};
      topic.update(times_json(t.recorded));
      json["topics"].push_back(topic);
    }
    json["uses"] = {{"scan_topic", info.suggested.choice.scan_topic},
                    {"odometry_topic", info.suggested.choice.odometry_topic},
                    {"map_topic", info.suggested.map_topic}};
    json["options"] = info.suggested.options;
  }
  if (info.log) {
    for (const auto& [name, scans] : info.log->lidars) json["lidars"][name] = scans_json(scans);
    json["odometry"] = odometry_json(info.log->odometry);
    json["broken_lines"] = info.log->warnings.broken_lines;
    json["notes"] = open_notes(info.log->warnings.notes, info.lidars);
    for (const LogNote& note : info.log->mounts) json["notes"].push_back(note.text);
    json["messages"] = info.log->warnings.messages;
  }
  if (!info.trouble.empty()) json["trouble"] = info.trouble;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace parloc::tools
