#include "tools/evaluate/question.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/eval/trial_summary.h"
#include "tools/report/text/numbers.h"

namespace parloc::tools::evaluate {
namespace {

constexpr double kEqual = 0.5;  // the share of what differs that either wins if they are equally good

Json interval_json(const RateInterval& interval) {
  return {interval.low, interval.high};
}

std::string interval_text(const RateInterval& interval) {
  return fmt::format("{:.1f} to {:.1f} %", 100.0 * interval.low, 100.0 * interval.high);
}

/// "95 of at most 1,000 trials".
std::string amount_text(std::size_t done, std::size_t wanted, const char* what) {
  return fmt::format("{} of at most {} {}", grouped(static_cast<std::int64_t>(done)),
                     grouped(static_cast<std::int64_t>(wanted)), what);
}

/// How many it would take, of which two digits are known at best.
std::string more_text(const std::optional<std::size_t>& more, const char* never) {
  if (!more) return never;
  return fmt::format("about {} more would decide, if all goes on as so far",
                     significant(static_cast<double>(*more), 2));
}

const char* word(Side side, const char* below, const char* above, const char* open = "open") {
  return side == Side::open ? open : side == Side::above ? above : below;
}

double mean_squared_error_m2(const TrialOutcome& o) {
  return o.squared_error_m2 / static_cast<double>(o.since_localized);
}

}  // namespace

Answer::Answer(const Question& question, double limit_s)
    : question_(question),
      limit_s_(limit_s),
      success_(question.bar.value_or(kEqual), question.error),
      winner_(kEqual, question.error) {}

void Answer::add(const TrialResult& trial, const TrialResult* other) {
  const bool here = succeeded(trial.outcome, limit_s_);
  ++(here ? trials_.hits : trials_.misses);
  if (other == nullptr) return;
  const bool there = succeeded(other->outcome, limit_s_);
  ++(here == there ? pairs_.alike : here ? pairs_.first_only : pairs_.second_only);
  if (here != there) (here ? here_only_ : other_only_).push_back(trial.seed);
  const double error = mean_squared_error_m2(trial.outcome),
               others_error = mean_squared_error_m2(other->outcome);
  if (others_error < error) ++nearer_.hits;  // neither, if one was never localized: NaN
  if (others_error > error) ++nearer_.misses;
}

bool Answer::decided() const {
  if (question_.bar) return success_.side(trials_) != Side::open;
  return question_.other && winner_.side(won()) != Side::open;
}

std::optional<std::size_t> Answer::more_trials() const {
  if (decided() || trials_.trials() == 0) return std::nullopt;
  if (question_.bar) return success_.more_trials(trials_);
  const std::optional<std::size_t> more = winner_.more_trials(won());
  if (!more) return std::nullopt;
  // Of all pairs as many differ as so far.
  const double pairs =
      static_cast<double>(*more) * static_cast<double>(pairs_.pairs()) / static_cast<double>(won().trials());
  if (pairs > RateSequence::kMostTrials) return std::nullopt;
  return static_cast<std::size_t>(std::ceil(pairs));
}

Facts Answer::facts(std::size_t wanted) const {
  return question_.bar ? bar_facts(wanted) : question_.other ? pair_facts(wanted) : Facts{};
}

Facts Answer::bar_facts(std::size_t wanted) const {
  const Side side = success_.side(trials_);
  const std::string amount = amount_text(trials_.trials(), wanted, "trials");
  const std::string bar = fmt::format("{:g} %", 100.0 * success_.bar());
  Facts facts;
  if (side == Side::open)
    add_fact(facts, "bar", "not decided after {}: whether success is {} or more; {}", amount, bar,
             more_text(more_trials(), "no number would: it looks to be at the bar"));
  else
    add_fact(facts, "bar", "{} after {}: success is {} {}", word(side, "missed", "reached"), amount,
             side == Side::above ? "more than" : "less than", bar);
  add_fact(facts, "... interval",
           "{} however often one looks; the answer is wrong in {:g} % of cases at most",
           interval_text(success_.interval(trials_)), 100.0 * success_.error());
  return facts;
}

Facts Answer::pair_facts(std::size_t wanted) const {
  const Side side = winner_.side(won());
  const std::string amount = amount_text(pairs_.pairs(), wanted, "pairs");
  const DifferenceInterval difference = difference_interval(pairs_, winner_.error());
  Facts facts;
  if (side == Side::open)
    add_fact(facts, "against", "no difference in success shown after {}: more than {:.1f} % is excluded; {}",
             amount, 100.0 * std::max(-difference.low, difference.high),
             more_text(more_trials(), "no number would: they look equally good"));
  else
    add_fact(facts, "against", "{} is {} in success, known after {}", question_.other_path,
             word(side, "worse", "better"), amount);
  const std::size_t others_hits = trials_.hits + pairs_.second_only - pairs_.first_only;
  add_fact(facts, "... success", "here {}, there {}; only here {}, only there {}", trials_.hits, others_hits,
           pairs_.first_only, pairs_.second_only);
  add_fact(facts, "... difference",
           "{:+.1f} %, {:+.1f} to {:+.1f} % however often one looks; wrong in {:g} % of cases at most",
           100.0 * static_cast<double>(pairs_.second_only) / static_cast<double>(pairs_.pairs()) -
               100.0 * static_cast<double>(pairs_.first_only) / static_cast<double>(pairs_.pairs()),
           100.0 * difference.low, 100.0 * difference.high, 100.0 * winner_.error());
  add_fact(facts, "... error", "smaller there in {} of {} pairs in which both were localized: {}",
           nearer_.hits, nearer_.trials(),
           word(winner_.side(nearer_), "mostly larger", "mostly smaller", "not decided"));
  return facts;
}

Json Answer::json() const {
  return question_.bar ? bar_json() : pair_json();
}

Json Answer::bar_json() const {
  return {{"bar", success_.bar()},
          {"error", success_.error()},
          {"answer", word(success_.side(trials_), "missed", "reached")},
          {"trials", trials_.trials()},
          {"hits", trials_.hits},
          {"interval", interval_json(success_.interval(trials_))},
          {"more_trials", json_of(more_trials())}};
}

Json Answer::pair_json() const {
  const DifferenceInterval difference = difference_interval(pairs_, winner_.error());
  return {{"against", question_.other_path},
          {"config", config_to_yaml(*question_.other)},
          {"error", winner_.error()},
          {"answer", word(winner_.side(won()), "worse", "better")},
          {"pairs", pairs_.pairs()},
          {"hits", trials_.hits},
          {"hits_other", trials_.hits + pairs_.second_only - pairs_.first_only},
          {"only_here", here_only_},
          {"only_other", other_only_},
          {"difference", {difference.low, difference.high}},
          {"more_trials", json_of(more_trials())},
          {"error_smaller",
           {{"answer", word(winner_.side(nearer_), "larger", "smaller")},
            {"smaller", nearer_.hits},
            {"larger", nearer_.misses}}}};
}

}  // namespace parloc::tools::evaluate
