#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/how_long.h"
#include "tools/report/machine/machine.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::evaluate {
namespace {

constexpr std::size_t kSeedsListed = 40;

/// "29 of 30 (96.7 %, 95 % interval 83.3 to 99.4)".
std::string rate_text(const Rate& r) {
  return fmt::format("{} of {} ({}, 95 % interval {:.1f} to {:.1f})", r.hits, r.trials, percent_text(r.share),
                     100.0 * r.low, 100.0 * r.high);
}

std::string spread_text(const Spread& s, const char* unit, int decimals) {
  if (s.count == 0) return "-";
  return fmt::format("median {1:.{0}f} {4}, 95th percentile {2:.{0}f} {4}, most {3:.{0}f} {4}", decimals,
                     s.median, s.p95, s.most, unit);
}

std::string nees_text(const MeanInterval& n) {
  if (n.count == 0) return "-";
  if (n.count == 1) return fmt::format("{:.2f} (3 is right; one trial has no interval)", n.mean);
  const char* verdict = 3.0 < n.low ? "over-confident" : 3.0 > n.high ? "over-cautious" : "3 lies within";
  return fmt::format("{:.2f}, 95 % interval {:.2f} to {:.2f} over {} trials: {}", n.mean, n.low, n.high,
                     n.count, verdict);
}

std::string missed_text(const TrialSummary& s) {
  if (s.wrong_s <= 0.0) return "it was never wrong";
  return fmt::format("it said tracking in {} of the {:.1f} s in which it was wrong",
                     percent_text(s.missed_lost), s.wrong_s);
}

std::string seeds_text(const std::vector<std::uint64_t>& seeds) {
  if (seeds.empty()) return "none";
  std::string text;
  for (std::size_t k = 0; k < seeds.size() && k < kSeedsListed; ++k)
    text += fmt::format("{}{}", k > 0 ? ", " : "", seeds[k]);
  if (seeds.size() > kSeedsListed)
    text += fmt::format(" and {} more (evaluate.json)", seeds.size() - kSeedsListed);
  return text;
}

}  // namespace

const char* name_of(TrialTask task) {
  return task == TrialTask::global ? "global" : task == TrialTask::kidnap ? "kidnap" : "track";
}

Facts result_facts(const Evaluation& e) {
  const TrialSummary& s = e.summary;
  Facts lines = e.answer ? e.answer->facts(e.wanted) : Facts{};
  add_fact(lines, "success", "{}: right within {:g} s, and for {:g} s from there", rate_text(s.success),
           e.limit_s, e.plan.hold_s);
  if (s.localized.hits == 0) {
    lines.push_back({"localized after", "never, in any trial"});
  } else {
    add_fact(lines, "localized after", "{} ({} of {} trials ever were)", spread_text(s.localize_s, "s", 1),
             s.localized.hits, s.trials);
    lines.push_back({"right ever since", rate_text(s.right_after) + ": of these, never wrong to the end"});
  }
  if (e.plan.task == TrialTask::kidnap) {
    lines.push_back(
        {"tracked before", rate_text(s.tracked_before) + ": right and tracking when it was kidnapped"});
    lines.push_back({"noticed", rate_text(s.noticed) + fmt::format(" within {:g} s", e.plan.grace_s)});
    lines.push_back({"noticed after", spread_text(s.notice_s, "s", 1)});
  }
  lines.push_back(
      {"sure but wrong", rate_text(s.confident_wrong) + ": trials that say tracking while wrong"});
  lines.push_back({"... for 1 s on", rate_text(s.confident_wrong_1s)});
  add_fact(lines, "false lost", "{} in {:.2f} h of driving while right: {} per hour", s.false_lost,
           s.right_s / 3600.0, fixed_text(s.false_lost_per_hour, 1));
  lines.push_back({"missed lost", missed_text(s)});
  if (s.localized.hits > 0) {
    add_fact(lines, "error", "{} m RMSE since it was localized", fixed_text(s.rmse_m, 4));
    lines.push_back({"NEES", nees_text(s.nees)});
  }
  add_fact(lines, "probability", "Brier {}, AUC {} over {} scans", fixed_text(s.calibration.brier, 4),
           fixed_text(s.calibration.auc, 4), s.samples);
  add_fact(lines, "searches", "{:.2f} per trial, most {:.0f}", s.searches_mean, s.searches_most);
  lines.push_back({"failed seeds", seeds_text(s.failed)});
  return lines;
}

std::size_t next_trials(const Evaluation& e) {
  constexpr std::size_t kMany = 1000;
  return e.answer ? e.answer->more_trials().value_or(kMany) : kMany;
}

Facts time_facts(const Evaluation& e) {
  Facts lines{{"step", spread_text(e.summary.step_ms, "ms", 2)},
              {"with search", spread_text(e.summary.search_ms, "ms", 1)},
              {"whole work", work_text(e.wall_s, e.jobs, e.shards)}};
  if (e.question.asked())
    add_fact(lines, "dropped", "{} trials that were finished beyond the one that decides", e.dropped);
  lines.push_back({fmt::format("{} more", next_trials(e)),
                   how_long_text(next_trials(e), e.trial_s, static_cast<std::size_t>(e.machine.cores))});
  add_fact(lines, "machine", "{}, {} core{}", e.machine.cpu, e.machine.cores,
           e.machine.cores == 1 ? "" : "s");
  return lines;
}

Facts origin_facts(const Evaluation& e) {
  const char* tasks[] = {"the start is not given",
                         "the start is given; half-way the robot is put somewhere else",
                         "the start is given"};
  Facts lines{{"trials", e.source}, {"map", e.map_path}};
  add_fact(lines, "task", "{}: {}", name_of(e.plan.task), tasks[static_cast<int>(e.plan.task)]);
  std::string amount = fmt::format("{} from seed {}", e.trials.size(), e.first_seed);
  if (e.plan.duration_s > 0.0)
    amount += fmt::format(", {:g} s{}", e.plan.duration_s, e.plan.task == TrialTask::kidnap ? " twice" : "");
  if (e.question.asked() && e.answer->decided()) amount += fmt::format(" of {}, which decide", e.wanted);
  if (e.interrupted) amount += fmt::format("; interrupted, {} were wanted", e.wanted);
  lines.push_back({"amount", amount});
  if (e.summary.unmapped > 0.0)
    lines.push_back({"clutter", percent_text(e.summary.unmapped) +
                                    " of the hits are on people and boxes that are not on the map"});
  add_fact(lines, "right", "within {:g} m and {:.0f} degrees of the truth", e.plan.near_m,
           e.plan.near_rad * 180.0 / 3.14159265358979);
  if (e.plan.duration_s > 0.0 && e.plan.duration_s < e.limit_s + e.plan.hold_s - 1e-9)
    add_fact(lines, "note", "a trial that is right only at {:g} s is watched for {:g} s, not {:g} s",
             e.limit_s, e.plan.duration_s > e.limit_s ? e.plan.duration_s - e.limit_s : 0.0, e.plan.hold_s);
  add_fact(lines, "filter", "{} particles", e.config.particles);
  lines.push_back({"build", version_text()});
  return lines;
}

std::vector<std::vector<std::string>> reliability_rows(const Evaluation& e) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = 0; k < e.summary.calibration.bins.size(); ++k) {
    const ReliabilityBin& bin = e.summary.calibration.bins[k];
    if (bin.count == 0) continue;
    rows.push_back(
        {fmt::format("{:.1f} to {:.1f}", 0.1 * static_cast<double>(k), 0.1 * static_cast<double>(k + 1)),
         std::to_string(bin.count), fmt::format("{:.3f}", bin.forecast_mean),
         fmt::format("{:.3f}", bin.observed)});
  }
  return rows;
}

std::string terminal_text(const Evaluation& e) {
  constexpr std::size_t kNames = 18;
  std::string text = aligned_text(origin_facts(e), kNames) + "\n" + aligned_text(result_facts(e), kNames);
  text += "\nprobability said    scans  mean said  was right\n";
  for (const auto& row : reliability_rows(e))
    fmt::format_to(std::back_inserter(text), "{:<16}{:>9}{:>11}{:>11}\n", row[0], row[1], row[2], row[3]);
  return text + "\nOn this machine:\n" + aligned_text(time_facts(e), kNames);
}

void write_samples(const Evaluation& e, const TextSink& sink) {
  sink(
      "seed,stamp_s,position_error_m,heading_error_rad,right,evidence,share,probability,state,searched,"
      "nees,log_odds\n");
  e.trials.each([&](const TrialResult& t) {
    std::string csv;
    for (const TrialSample& s : t.samples)
      fmt::format_to(std::back_inserter(csv),
                     "{},{:.6f},{:.6g},{:.6g},{:d},{:.9g},{:.9g},{:.9g},{},{:d},{:.6g},{:.9g}\n", t.seed,
                     s.stamp_s, s.position_error_m, s.heading_error_rad, is_right(e.plan, s), s.evidence,
                     s.share, s.probability, parloc::name_of(s.state), s.searched, s.nees, s.log_odds);
    sink(csv);
  });
}

}  // namespace parloc::tools::evaluate
