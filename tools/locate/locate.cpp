// parloc locate: where on the map was one scan taken?
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/error.h"
#include "common/file/output_file.h"
#include "common/filter/filter_settings.h"
#include "common/inputs/open_log.h"
#include "common/inputs/open_map.h"
#include "common/io/scan_file.h"
#include "common/io/scan_stream.h"
#include "common/model/beams.h"
#include "common/model/lidar.h"
#include "common/search/global_search.h"
#include "tools/program/commands.h"
#include "tools/program/note_teller.h"
#include "tools/program/output_folder.h"
#include "tools/program/parse_number.h"
#include "tools/report/machine/statistics.h"
#include "tools/report/map_picture.h"

namespace parloc::tools {
namespace {

/// The command line; what was not given is empty.
struct LocateOptions : ConfigOptions {
  std::string map, log, at, number, scan, top, near, heading, out;
  bool json = false;
};

void declare(CLI::App& app, LocateOptions& o) {
  add_text_option(app, "--map", o.map, "M.yaml", "ROS map_server YAML, or segments")->required();
  add_log_options(app, o, o.log);
  add_text_option(app, "--at", o.at, "S", "Its first scan from S seconds after the first one (0)");
  add_text_option(app, "--scan-number", o.number, "N", "Or its Nth scan, from 1");
  add_text_option(app, "--scan", o.scan, "S.yaml", "Or one scan from a YAML file");
  add_text_option(app, "--config", o.config, "C.yaml", "Settings of scan, lidars, search and backend");
  add_text_option(app, "--near", o.near, "X,Y,R", "Only within R of (X, Y) [m]");
  add_text_option(app, "--heading", o.heading, "A,T", "Only headings from A - T to A + T [rad]");
  add_text_option(app, "--top", o.top, "K", "Print at most K places (10)");
  add_text_option(app, "--out", o.out, "DIR", "Write hypotheses.json and picture.png there");
  add_choice_option(app, "--backend", o.backend, kBackends, "WHICH", "auto, cpu or cuda");
  add_text_option(app, "--device", o.device, "D", "CUDA device, as parloc devices lists them");
  add_text_option(app, "--threads", o.threads, "K", "CPU threads; 0: all cores");
  add_text_option(app, "--beams", o.beams, "B", "Beams used of the scan, 1 to 4096");
  app.add_flag("--json", o.json, "Print the result as JSON");
  app.footer(
      "Searches every free place and heading of the map. Exit code 7: no place explains the scan.\n"
      "docs/locate.md");
}

SearchConfig search_config(const LocateOptions& o, const Config& config) {
  SearchConfig c = config.search;
  if (!o.top.empty()) c.most = parse_whole_number<int>("--top", o.top, 1, c.candidates);
  return c;
}

struct ChosenScan {
  Scan scan;
  std::string name;  ///< For people.
};

ChosenScan scan_of_log(const LocateOptions& o, const Config& config) {
  const double at_s = o.at.empty() ? 0.0 : parse_number("--at", o.at, 0.0, 1e9);
  const auto number = o.number.empty() ? 0 : parse_whole_number<std::size_t>("--scan-number", o.number);
  if (!o.number.empty() && number == 0)
    throw Error(ErrorKind::usage, "--scan-number: expected a whole number from 1 up, got '0'");
  const auto log = open_log(o.log, log_choice(config));
  NoteTeller notes(o.log, config.lidars);
  std::size_t seen = 0;
  double first_s = 0.0;
  for (LogRecord record; log->next(record);) {
    notes.tell(log->warnings());
    if (record.kind != RecordKind::scan) continue;
    if (++seen == 1) first_s = record.stamp_s;
    if (number > 0 ? seen == number : record.stamp_s - first_s >= at_s)
      return {record.scan,
              fmt::format("scan {} of {}, {:.3f} s after the first", seen, o.log, record.stamp_s - first_s)};
  }
  if (seen == 0) throw no_scan(o.log, log->warnings());
  throw input_error(o.log, 0,
                    number > 0
                        ? fmt::format("expected {} scans, found {}", number, seen)
                        : fmt::format("expected a scan {} s after the first, the log ends before", at_s));
}

ChosenScan choose_scan(const LocateOptions& o, const Config& config) {
  if (!o.log.empty() && !o.scan.empty()) throw Error(ErrorKind::usage, "expected --log or --scan, not both");
  if (o.log.empty() && !(o.at.empty() && o.number.empty()))
    throw Error(ErrorKind::usage, "--at and --scan-number choose a scan of a log: expected --log");
  if (!o.at.empty() && !o.number.empty())
    throw Error(ErrorKind::usage, "expected --at or --scan-number, not both");
  if (!o.scan.empty()) return {read_scan(o.scan), o.scan};
  if (o.log.empty()) throw Error(ErrorKind::usage, "expected a scan: --log LOG or --scan S.yaml");
  return scan_of_log(o, config);
}

/// Everything that is told of a search.
struct Located {
  SearchResult result;
  std::string scan, map, backend;
  std::size_t beams = 0, hits = 0, beams_of_scan = 0;
  double map_s = 0.0, search_s = 0.0;

  const char* verdict() const {
    return result.hypotheses.empty() ? "none" : result.ambiguous ? "ambiguous" : "found";
  }
};

nlohmann::ordered_json as_json(const Located& l) {
  nlohmann::ordered_json j;
  j["verdict"] = l.verdict();
  j["map"] = l.map;
  j["scan"] = l.scan;
  j["backend"] = l.backend;
  j["beams_used"] = l.beams;
  j["hits_used"] = l.hits;
  j["headings"] = l.result.headings;
  j["places_judged"] = l.result.candidates;
  j["more_places_than_judged"] = l.result.too_many;
  j["map_s"] = l.map_s;
  j["search_s"] = l.search_s;
  j["hypotheses"] = nlohmann::ordered_json::array();
  for (const Hypothesis& h : l.result.hypotheses)
    j["hypotheses"].push_back({{"x_m", h.pose.x_m},
                               {"y_m", h.pose.y_m},
                               {"theta_rad", h.pose.theta_rad},
                               {"weight", h.weight},
                               {"as_good_as_first", h.as_good},
                               {"score", h.score},
                               {"explained", h.explained},
                               {"through_walls", h.through},
                               {"unmapped", h.unmapped},
                               {"evidence", h.evidence}});
  return j;
}

void print_table(const Located& l) {
  fmt::print("scan        {}: {} beams, {} used, {} of them hits\n", l.scan, l.beams_of_scan, l.beams,
             l.hits);
  fmt::print("search      {} headings, {} places judged, {}\n", l.result.headings, l.result.candidates,
             l.backend);
  fmt::print("time        {:.3f} s, and {:.3f} s to prepare the map\n", l.search_s, l.map_s);
  if (l.result.hypotheses.empty()) {
    fmt::print("answer      none: no place of the map explains this scan\n");
    return;
  }
  const auto good = std::count_if(l.result.hypotheses.begin(), l.result.hypotheses.end(),
                                  [](const Hypothesis& h) { return h.as_good; });
  if (!l.result.ambiguous)
    fmt::print("answer      found: one place explains the scan clearly better than all others\n");
  else if (l.result.too_many)
    fmt::print("answer      ambiguous: more places fit than were judged\n");
  else
    fmt::print("answer      ambiguous: {} places explain the scan about as well (marked *)\n", good);
  fmt::print("\n      x [m]     y [m]  theta [rad]  weight  score  explained  through  unmapped\n");
  int number = 0;
  for (const Hypothesis& h : l.result.hypotheses)
    fmt::print("{:2d}{}{:9.3f} {:9.3f} {:12.4f} {:7.3f} {:6.3f} {:8.1f} % {:6.1f} % {:7.1f} %\n", ++number,
               h.as_good ? "*" : " ", h.pose.x_m, h.pose.y_m, h.pose.theta_rad, h.weight, h.score,
               100.0 * h.explained, 100.0 * h.through, 100.0 * h.unmapped);
}

constexpr const char* kHypothesesJson = "hypotheses.json";
constexpr const char* kPlacesPicture = "picture.png";

int locate(const LocateOptions& o, const std::string&) {
  // Everything that can be wrong is looked at before the long work.
  const Config config = effective_config(o);
  const SearchConfig searching = search_config(o, config);
  const SearchPrior prior = parse_search_prior(o.near, o.heading);
  const GridMap map = open_map(o.map, log_choice(config));
  print_notes(map.notes);
  const ChosenScan chosen = choose_scan(o, config);
  std::unique_ptr<OutputFolder> out;
  if (!o.out.empty())
    out = std::make_unique<OutputFolder>(o.out, std::vector<std::string>{kHypothesesJson, kPlacesPicture});

  const LidarSetup setup =
      lidar_setup(chosen.scan, config.scan, find_lidar(config.lidars, chosen.scan.sensor));
  BeamTable beams;
  BeamCounts counts;
  select_beams(chosen.scan, setup, nullptr, config.sensor, map.resolution_m, beams, counts);
  Located l;
  l.scan = chosen.name, l.map = o.map;
  l.beams = beams.count, l.hits = beams.hits, l.beams_of_scan = chosen.scan.ranges_m.size();
  Clock::time_point begun = Clock::now();
  GlobalSearch search(map, searching, config);
  l.map_s = seconds_since(begun);
  l.backend = search.backend_name();
  begun = Clock::now();
  if (beams.count >= static_cast<std::size_t>(config.scan.min_beams)) l.result = search.search(beams, prior);
  l.search_s = seconds_since(begun);

  const std::string text = as_json(l).dump(2) + "\n";
  if (out) {
    replace_file(out->staged(kHypothesesJson), text);
    write_hypothesis_picture(out->staged(kPlacesPicture), map, l.result.hypotheses,
                             end_points(chosen.scan, setup, nullptr));
    out->publish();
  }
  if (o.json)
    fmt::print("{}", text);
  else
    print_table(l);
  return l.result.hypotheses.empty() ? kExitNotFound : 0;
}

}  // namespace

Command add_locate_command(CLI::App& program) {
  return add_command<LocateOptions>(program, "locate", "Find where on the map one scan was taken", declare,
                                    locate);
}

}  // namespace parloc::tools
