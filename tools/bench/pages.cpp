#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "tools/bench/forms.h"
#include "tools/bench/steps/scenes.h"
#include "tools/report/machine/machine.h"
#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools::bench {
namespace {

constexpr std::size_t kTerminalWidth = 100;

/// The tables of one scene and cloud: the gist, what everyone wants to see, and the rest.
struct Tables {
  std::vector<Table> gist, first, details;
};

Tables tables_of(const Results& r, const Place& place) {
  Tables t;
  const auto add = [](std::vector<Table>& to, Table table) {
    if (!table.rows.empty()) to.push_back(std::move(table));
  };
  if (!r.scale) {
    for (const PublishedTable& published : published_tables())
      add(t.first, published_table(r, place, published));
    add(t.gist, peers_table(r, place));
    add(t.gist, summary_table(r, place));
    Table details = detail_table(r, place, Sweep::tables);
    details.title = "Every time";
    add(t.details, std::move(details));
    return t;
  }
  Table particles = detail_table(r, place, Sweep::particles);
  particles.title = "Particles";
  add(t.first, std::move(particles));
  for (std::size_t v = 0; v < r.variants.size(); ++v) add(t.first, stage_table(r, place, v));
  add(t.first, beams_table(r, place));
  add(t.first, threads_table(r, place));
  add(t.gist, largest_table(r, place));
  return t;
}

/// `text` in lines of at most `width` characters, broken at blanks; the second and later ones begin with
/// `indent`.
std::string wrapped(const std::string& text, std::size_t width, const std::string& indent) {
  std::string out;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && line.find_first_not_of(' ') != std::string::npos &&
        line.size() + 1 + word.size() > width) {
      out += line + "\n";
      line = indent + word;
    } else {
      line += (at == 0 ? "" : " ") + word;
    }
    at = end + 1;
  }
  return out + line + "\n";
}

/// What a reader must know: machine, build, sensor, what is inside the time, what the numbers are.
Facts facts(const Results& r) {
  Facts lines{{"machine", fmt::format("{}, {} core{}, {:.0f} GB, {}", r.machine.cpu, r.machine.cores,
                                      r.machine.cores == 1 ? "" : "s",
                                      1e-9 * static_cast<double>(r.machine.memory_bytes), r.machine.os)}};
  for (const std::string& device : r.machine.devices) lines.push_back({"device", device});
  if (!r.machine.gpu_driver.empty()) lines.push_back({"driver", r.machine.gpu_driver});
  add_fact(lines, "build", "{}, {}, {}: {}", version_text(), kCompiler, kBuildType, kFlags);
  if (r.machine.load_average >= 0.0)
    add_fact(lines, "load", "{:.2f} in the minute before (other work makes times longer)",
             r.machine.load_average);
  for (const std::string& setting : r.machine.settings) lines.push_back({"setting", setting});
  add_fact(lines, "sensor", "{:g} m, beams over {:g} degrees; Gaussian model, sigma 0.1 m, tempering 1",
           kRangeMax_m, kFieldOfView_deg);
  lines.push_back({"inside",
                   "one whole filter step, from odometry and raw scan to the estimate, uploads and "
                   "downloads included"});
  add_fact(lines, "times", "medians of {} steps or more after a warm-up, about {:g} s per row",
           r.rules.least_steps, r.rules.seconds);
  if (!r.scale)
    lines.push_back(
        {"others",
         "the sensor model that the table names, with its defaults; another machine, so that their ratio is "
         "a hint, no measurement"});
  if (!r.scale)
    lines.push_back({"marks",
                     "* within 40 ms; ratio: time here over the published time; speed-up: over paz2012 on 1 "
                     "thread, here; size: particles x beams"});
  return lines;
}

/// What was not measured, and why; whether the run was interrupted.
std::vector<std::string> remarks(const Results& r) {
  std::vector<std::string> lines;
  if (r.interrupted) lines.push_back("interrupted: only what was finished by then is here");
  lines.insert(lines.end(), r.notes.begin(), r.notes.end());
  const std::vector<std::string> skipped = skipped_lines(r.skipped);
  lines.insert(lines.end(), skipped.begin(), skipped.end());
  return lines;
}

/// "no_hit, cloud tracking (800 x 600 ...)".
std::string heading(const Results& results, const Place& place) {
  for (const SceneFacts& scene : results.scenes) {
    if (scene.name == place.scene)
      return fmt::format("{}, cloud {} ({})", scene.name, place.cloud, scene.what);
  }
  return place.scene;
}

}  // namespace

std::string terminal_page(const Results& r) {
  std::string text;
  for (const auto& [name, value] : facts(r))
    text += wrapped(fmt::format("{:<9}{}", name, value), kTerminalWidth, std::string(9, ' '));
  for (const Place& place : r.places()) {
    text += "\n" + wrapped("== " + heading(r, place), kTerminalWidth, "   ");
    const Tables tables = tables_of(r, place);
    for (const auto* part :
         {&tables.first, &tables.gist})  // what is read first stands last, above the prompt
      for (const Table& table : *part) text += "\n" + terminal_text(table, kTerminalWidth);
  }
  const std::vector<std::string> lines = remarks(r);
  if (!lines.empty()) text += "\n";
  for (const std::string& line : lines) text += wrapped("- " + line, kTerminalWidth, "  ");
  return text + "\n";
}

std::string markdown_page(const Results& r) {
  std::string text = fmt::format("# parloc bench{}\n\n", r.scale ? ": how it scales" : "");
  text += fmt::format("Measured {} with `{}`.\n\n", r.date, r.command);
  text += markdown_list(facts(r));
  for (const std::string& line : remarks(r)) text += fmt::format("- **{}**\n", line);
  for (const Place& place : r.places()) {
    text += fmt::format("\n## {}\n", heading(r, place));
    const Tables tables = tables_of(r, place);
    for (const auto* part : {&tables.gist, &tables.first, &tables.details})
      for (const Table& table : *part) text += "\n" + markdown_text(table);
  }
  return text;
}

std::string html_page(const Results& r) {
  const std::string title =
      r.scale ? "parloc bench: how it scales" : "parloc bench: beside the published times";
  std::string html = page_head(title, r.date, r.command);
  const std::vector<std::string> lines = remarks(r);
  if (!lines.empty()) {
    html += "<div class=\"warning\"><ul>";
    for (const std::string& line : lines) html += "<li>" + escape_html(line) + "</li>";
    html += "</ul></div>\n";
  }
  for (const Place& place : r.places()) {
    html += fmt::format("<h2>{}</h2>\n", escape_html(heading(r, place)));
    html += r.scale ? scale_plots(r, place) : published_plots(r, place);
    const Tables tables = tables_of(r, place);
    for (const auto* part : {&tables.gist, &tables.first})
      for (const Table& table : *part) html += html_text(table);
    if (tables.details.empty()) continue;
    html += "<details><summary>Every time with its quartiles and p99</summary>\n";
    for (const Table& table : tables.details) html += html_text(table);
    html += "</details>\n";
  }
  return html + "<h2>How it was measured</h2>\n" + facts_table(facts(r)) + "</body></html>\n";
}

}  // namespace parloc::tools::bench
