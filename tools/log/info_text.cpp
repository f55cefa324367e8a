#include "tools/log/info_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/error.h"
#include "common/io/log_notes.h"
#include "common/math/portable64.h"
#include "tools/report/text/numbers.h"
#include "tools/report/text/table.h"

namespace parloc::tools {

namespace {

double degrees(double angle_rad) {
  return angle_rad * 180.0 / kPi;
}

std::uint64_t bytes_of(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code none;
  if (!fs::is_directory(path, none)) return fs::file_size(path, none);
  std::uint64_t sum = 0;
  for (const auto& entry : fs::directory_iterator(path, none))
    if (entry.is_regular_file(none)) sum += entry.file_size(none);
  return sum;
}

std::string size_of(std::uint64_t bytes) {
  const double value = static_cast<double>(bytes);
  return value < 1e6 ? fmt::format("{:.1f} kB", value / 1e3) : fmt::format("{:.1f} MB", value / 1e6);
}

/// A date where the stamp can be one: clocks of simulators begin at 0.
std::string time_text(double stamp_s) {
  constexpr double year_1973 = 1e8, year_2286 = 1e10;
  if (stamp_s < year_1973 || stamp_s > year_2286) return fmt::format("{:.3f} s", stamp_s);
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(stamp_s)));
}

std::string rate_text(const StampSurvey& stamps) {
  const auto period_s = stamps.period_s();
  return period_s ? fmt::format("{} Hz", significant(1.0 / *period_s, 3)) : "-";
}

/// What is odd about times; empty if nothing is.
std::string time_troubles(const StampSurvey& stamps) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
  if (stamps.repeated() > 0) add(fmt::format("{} stamps stand still", stamps.repeated()));
  if (stamps.backward() > 0) add(fmt::format("{} run backwards", stamps.backward()));
  const StampSurvey::Gap gap = stamps.longest_gap();
  const auto period_s = stamps.period_s();
  if (period_s && gap.length_s > 3.0 * *period_s)
    add(fmt::format("longest gap {} s, {:.1f} s after the first", significant(gap.length_s, 3),
                    gap.at_s - stamps.first_s()));
  return text;
}

std::string with(const std::string& text, const std::string& more) {
  return more.empty() ? text : text + "; " + more;
}

std::string path_in_shell(const std::string& path) {
  const bool plain = !path.empty() && std::all_of(path.begin(), path.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("/._-+=@:,").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return path;
  std::string quoted = "'";
  for (const char c : path) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The likeliest thing that a reading without a return is written as.
std::string no_return_text(const ScanSurvey& s) {
  const std::pair<std::size_t, std::string> kinds[] = {{s.zero, "0"},
                                                       {s.infinite, "inf"},
                                                       {s.not_a_number, "NaN"},
                                                       {s.negative, "below 0"},
                                                       {s.far, "the maximum or more"}};
  std::string text;
  for (const auto& [count, name] : kinds)
    if (count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ",
                          percent_text(static_cast<double>(count) / static_cast<double>(s.readings())), name);
  return text.empty() ? "none without a return" : "no return: " + text;
}

void add_scans(Facts& facts, const std::string& name, const ScanSurvey& s) {
  const StampSurvey& stamps = s.stamps;
  add_fact(facts, "scans", "{}: {}", name.empty() ? "(no name)" : printable(name),
           with(fmt::format("{} in {:.1f} s, {}", stamps.count(), stamps.last_s() - stamps.first_s(),
                            rate_text(stamps)),
                time_troubles(stamps)));
  std::string beams;
  for (const auto& [count, scans] : s.scans_of_beams)
    beams += s.scans_of_beams.size() == 1 ? fmt::format("{}", count)
                                          : fmt::format("{}{} (in {} scan{})", beams.empty() ? "" : ", ",
                                                        count, scans, scans == 1 ? "" : "s");
  add_fact(facts, "  beams", "{}; {:.2f} to {:.2f} degrees, {}{}", beams, degrees(s.first_bearing_rad),
           degrees(s.last_bearing_rad),
           s.uneven ? "uneven" : fmt::format("a step of {:.4f}", std::fabs(degrees(s.angle_step_rad))),
           s.scan_time_s > 0.0 ? fmt::format("; a scan takes {:.4f} s", s.scan_time_s) : "");
  add_fact(facts, "  ranges", "{}; the log says {} to {} m; {}",
           s.good > 0 ? fmt::format("{:.2f} to {:.2f} m", s.nearest_m, s.farthest_m) : "none in range",
           s.range_min_m > 0.0 ? significant(s.range_min_m, 3) : "?",
           s.range_max_m > 0.0 ? significant(s.range_max_m, 4) : "?", no_return_text(s));
  add_fact(facts, "  sits at", "x {:.3f} m, y {:.3f} m, yaw {:.2f} degrees{}{}", s.T_base_sensor.x_m,
           s.T_base_sensor.y_m, degrees(s.T_base_sensor.theta_rad), s.upside_down ? ", upside down" : "",
           s.mount_moves ? "; it moves" : "");
}

void add_odometry(Facts& facts, const OdometrySurvey& o) {
  if (o.length_m == 0.0 && o.turned_rad == 0.0) {
    add_fact(facts, "odometry", "none, or the robot never moved by it");
    return;
  }
  add_fact(facts, "odometry", "{}",
           with(fmt::format("{} readings, {}, {} of them beside the scans'", o.stamps.count(),
                            rate_text(o.stamps), o.alone),
                time_troubles(o.stamps)));
  add_fact(facts, "  drive", "{} m, turned by {:.0f} degrees; up to {} m/s and {:.0f} degrees/s",
           significant(o.length_m, 4), degrees(o.turned_rad), significant(o.max_speed_mps, 3),
           degrees(o.max_turn_rate_rad_s));
  if (o.standing_s > 0.0)
    add_fact(facts, "  standing", "{:.1f} s in all; from reading to reading {} mm and {} degrees then",
             o.standing_s, significant(1e3 * o.standing_noise_m, 2),
             significant(degrees(o.standing_noise_rad), 2));
}

std::string topics_text(const BagSurvey& bag) {
  Table table;
  table.columns = {{"", "topic", true}, {"", "type", true}, {"", "messages"},
                   {"", "rate"},        {"", "size"},       {"", "longest gap"}};
  for (const TopicSurvey& t : bag.topics) {
    const StampSurvey::Gap gap = t.recorded.longest_gap();
    const auto rate_hz = t.recorded.mean_rate_hz();
    const bool odd = rate_hz && gap.length_s > 3.0 / *rate_hz;
    table.rows.push_back({printable(t.topic.name), printable(t.topic.type),
                          fmt::format("{}", t.recorded.count()),
                          rate_hz ? significant(*rate_hz, 3) + " Hz" : "-", size_of(t.bytes),
                          odd ? fmt::format("{:.2f} s", gap.length_s) : ""});
  }
  return terminal_text(table, 200);
}

/// From the first stamp to the last of anything.
std::pair<double, double> times_of(const LogInfo& info) {
  double first_s = INFINITY, last_s = -INFINITY;
  const auto take = [&](const StampSurvey& stamps) {
    if (stamps.count() == 0) return;
    first_s = std::min(first_s, stamps.first_s());
    last_s = std::max(last_s, stamps.last_s());
  };
  if (info.bag) {
    for (const TopicSurvey& topic : info.bag->topics) take(topic.recorded);
  } else if (info.log) {
    take(info.log->odometry.stamps);
  }
  return {first_s, last_s};
}

std::string head_text(const LogInfo& info) {
  const auto [first_s, last_s] = times_of(info);
  std::string text =
      fmt::format("{}: {}, {}", info.path, info.bag ? "bag (" + info.bag->container + ")" : "CARMEN",
                  size_of(bytes_of(info.path)));
  if (last_s >= first_s) text += fmt::format(", {:.1f} s from {}", last_s - first_s, time_text(first_s));
  if (info.bag) text += fmt::format(", {} messages", info.bag->messages());
  return text;
}

std::vector<std::string> warnings_of(const LogInfo& info) {
  std::vector<std::string> lines = info.suggested.reasons;
  if (!info.log) return lines;
  const LogWarnings& w = info.log->warnings;
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) lines.push_back(fmt::format("{} {}", count, what));
  };
  add(w.broken_lines, info.bag ? "faults of the bag" : "broken lines");
  add(w.backward_stamps, "scans go back in time");
  for (const auto& [name, count] : w.unread) lines.push_back(fmt::format("{} {}: not read", count, name));
  for (const std::string& note : open_notes(w.notes, info.lidars)) lines.push_back(note);
  for (const LogNote& note : info.log->mounts) lines.push_back(note.text);
  lines.insert(lines.end(), w.messages.begin(), w.messages.end());
  return lines;
}

/// The command lines that would run it.
void add_commands(Facts& facts, const LogInfo& info) {
  if (!info.log || info.log->lidars.empty()) return;
  std::string log = "--log " + path_in_shell(info.path), map = "--map MAP.yaml ";
  std::vector<std::string> of_log, of_map;
  for (const std::string& option : info.suggested.options)
    (option.starts_with("--map") ? of_map : of_log).push_back(option);
  if (!of_log.empty()) log += fmt::format(" {}", fmt::join(of_log, " "));
  if (!info.suggested.map_topic.empty()) map = of_map.empty() ? "" : of_map.front() + " ";
  const OdometrySurvey& o = info.log->odometry;
  const bool moved = o.length_m > 0.0 || o.turned_rad > 0.0;
  if (moved) add_fact(facts, "run it", "parloc run {} {}--init global --out out", log, map);
  add_fact(facts, moved ? "or map it" : "map it", "parloc slam {}{} --out my_map", log,
           info.suggested.no_odometry ? " --config NO_ODOMETRY.yaml" : "");
  if (info.suggested.no_odometry)
    add_fact(facts, "", "where NO_ODOMETRY.yaml says: slam: {{odometry: scans}}");
}

}  // namespace

std::string info_text(const LogInfo& info) {
  Facts facts{{"log", head_text(info)}};
  std::string text = aligned_text(facts, 12);
  if (info.bag && !info.bag->topics.empty()) text += "\n" + topics_text(*info.bag) + "\n";
  facts.clear();
  if (info.log) {
    for (const auto& [name, scans] : info.log->lidars) add_scans(facts, name, scans);
    if (info.log->lidars.empty()) add_fact(facts, "scans", "none");
    add_odometry(facts, info.log->odometry);
  }
  if (!info.suggested.map_topic.empty()) add_fact(facts, "map", "{}", printable(info.suggested.map_topic));
  for (const std::string& line : warnings_of(info)) facts.push_back({"note", line});
  add_commands(facts, info);
  return text + aligned_text(facts, 12);
}

}  // namespace parloc::tools
