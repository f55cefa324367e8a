#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "tools/evaluate/families/families_report.h"

namespace parloc::tools::families {
namespace {

constexpr std::size_t kWidth = 118, kSeedsListed = 40;

std::string number(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}
std::string percent(double share, int decimals = 1) {
  return number(100.0 * share, decimals);
}
/// "199 of 200".
std::string of(const Rate& r) {
  return fmt::format("{} of {}", r.hits, r.trials);
}

std::vector<const FamilySummary*> rows_of(const FamiliesReport& report) {
  std::vector<const FamilySummary*> rows;
  for (const FamilySummary& family : report.families) rows.push_back(&family);
  if (rows.size() > 1) rows.push_back(&report.all);
  return rows;
}

/// The bar: the loop against the bare filter, where that does its work.
Table harm_table(const FamiliesReport& report) {
  Table table;
  table.title =
      "Where the bare filter stays within 0.5 m, the closed loop makes it no worse (RMSE 1.1 times, largest "
      "error + 0.1 m)";
  table.columns = {{"", "family", true},         {"", "drives"},
                   {"no worse", "drives"},       {"no worse", "%"},
                   {"no worse", "95 %"},         {"RMSE [m], median", "loop"},
                   {"RMSE [m], median", "bare"}, {"largest [m]", "loop"},
                   {"largest [m]", "bare"},      {"99 % within 0.5 m", "loop"},
                   {"99 % within 0.5 m", "bare"}};
  for (const FamilySummary* s : rows_of(report))
    table.rows.push_back({s->family, std::to_string(s->drives), of(s->kept), percent(s->kept.share),
                          fmt::format("{} to {}", percent(s->kept.low), percent(s->kept.high)),
                          number(s->closed.rmse_m.median, 3), number(s->bare.rmse_m.median, 3),
                          number(s->closed.largest_m, 2), number(s->bare.largest_m, 2),
                          std::to_string(s->closed.nearly_all_within.hits),
                          std::to_string(s->bare.nearly_all_within.hits)});
  return table;
}

/// What the loop says of itself.
Table trust_table(const FamiliesReport& report) {
  Table table;
  table.title = "What the closed loop says, and whether it is so";
  table.columns = {{"", "family", true},
                   {"% of the scans", "within"},
                   {"% of the scans", "tracking"},
                   {"% of the scans", "ambiguous"},
                   {"% of the scans", "lost"},
                   {"sure but wrong", "% of time"},
                   {"sure but wrong", "after 10 s, % of scans"},
                   {"sure but wrong", "drives with 1 s"},
                   {"NEES", "mean"},
                   {"NEES", "median"},
                   {"probability", "AUC"},
                   {"probability", "error"},
                   {"", "searches"}};
  for (const FamilySummary* s : rows_of(report)) {
    const RunsSummary& r = s->closed;
    const auto state = [&](HealthState which) {
      return percent(r.by_state[static_cast<std::size_t>(which)]);
    };
    table.rows.push_back({s->family, percent(r.within), state(HealthState::tracking),
                          state(HealthState::ambiguous), state(HealthState::lost), percent(r.sure_wrong, 2),
                          percent(r.late_sure_wrong, 2), std::to_string(r.sure_wrong_1s.hits),
                          number(r.nees.mean, 2), number(r.nees_median, 2), number(r.calibration.auc, 4),
                          number(r.calibration_error, 4), number(r.searches, 1)});
  }
  return table;
}

}  // namespace

std::vector<Table> result_tables(const FamiliesReport& report) {
  return {harm_table(report), trust_table(report)};
}

Facts failed_facts(const FamiliesReport& report) {
  Facts facts;
  for (const FamilySummary& family : report.families) {
    if (family.failed.empty()) continue;
    std::string seeds;
    for (std::size_t k = 0; k < family.failed.size() && k < kSeedsListed; ++k)
      seeds += fmt::format("{}{}", k > 0 ? ", " : "", family.failed[k]);
    if (family.failed.size() > kSeedsListed)
      seeds += fmt::format(" and {} more (families.json)", family.failed.size() - kSeedsListed);
    facts.push_back({family.family, seeds});
  }
  if (facts.empty()) facts.push_back({"none", ""});
  return facts;
}

Facts origin_facts(const FamiliesReport& report) {
  Facts facts{{"drives", report.source},
              {"amount", fmt::format("{} of {} drives, seeds from {} on; {:.0f} s driven, {} scans, twice",
                                     report.drives.size(), report.wanted, report.first_seed,
                                     report.all.driven_s, report.all.scans)}};
  for (const FamilySummary& s : report.families) {
    if (s.family == "corridor")
      facts.push_back(
          {"along corridors", fmt::format("{} m RMS error at the end, {} m said",
                                          number(s.closed.x_error_m, 3), number(s.closed.sigma_x_m, 3))});
    if (s.family == "kidnapped")
      facts.push_back({"kidnapped", fmt::format("noticed within 2 s: {}; found within 5 s: {}",
                                                of(s.closed.noticed_2s), of(s.closed.localized_5s))});
    if (s.family == "unknown_start")
      facts.push_back({"unknown start", fmt::format("found within 5 s: {}", of(s.closed.localized_5s))});
  }
  facts.push_back({"filter", fmt::format("{} particles", report.config.particles)});
  facts.push_back({"build", version_text()});
  return facts;
}

Facts time_facts(const FamiliesReport& report) {
  TimeTally steps;
  report.drives.each([&](const DriveResult& d) {
    for (const SampleMark mark : d.closed.marks) steps.add(mark);
  });
  const Spread spread = steps.spread_ms();
  return {{"step", fmt::format("median {:.2f} ms, 95th percentile {:.2f} ms, most {:.1f} ms", spread.median,
                               spread.p95, spread.most)},
          {"whole work", work_text(report.wall_s, report.jobs, report.shards)},
          {"machine", fmt::format("{}, {} core{}", report.machine.cpu, report.machine.cores,
                                  report.machine.cores == 1 ? "" : "s")}};
}

std::string terminal_text(const FamiliesReport& report) {
  constexpr std::size_t kNames = 18;
  std::string text = aligned_text(origin_facts(report), kNames) + "\n";
  for (const Table& table : result_tables(report)) text += tools::terminal_text(table, kWidth) + "\n";
  text += "Seeds in which the loop made it worse (--families --family NAME --seed S --trials 1):\n" +
          aligned_text(failed_facts(report), kNames);
  return text + "\nOn this machine:\n" + aligned_text(time_facts(report), kNames);
}

void write_samples(const FamiliesReport& report, const TextSink& sink) {
  sink(
      "family,seed,run,stamp_s,position_error_m,heading_error_rad,right,evidence,share,probability,state,"
      "searched,nees,x_error_m,sigma_x_m,log_odds\n");
  const TrialPlan rule;
  report.drives.each([&](const DriveResult& d) {
    std::string csv;
    for (const TrialResult* run : {&d.closed, &d.bare})
      for (const TrialSample& s : run->samples)
        fmt::format_to(std::back_inserter(csv),
                       "\"{}\",{},{},{:.6f},{:.6g},{:.6g},{:d},{:.9g},{:.9g},{:.9g},{},{:d},{:.6g},{:.6g},{:."
                       "6g},{:.9g}\n",
                       d.family, d.seed, run == &d.closed ? "loop" : "bare", s.stamp_s, s.position_error_m,
                       s.heading_error_rad, is_right(rule, s), s.evidence, s.share, s.probability,
                       parloc::name_of(s.state), s.searched, s.nees, s.x_error_m, s.sigma_x_m, s.log_odds);
    sink(csv);
  });
}

}  // namespace parloc::tools::families
