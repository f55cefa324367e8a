#include "tools/shards/trial_bytes.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "tools/shards/value_bytes.h"

namespace parloc::tools::shards {
namespace {

/// The fields in the order of the bytes; `visit` puts or gets one.
template <class Outcome, class Visit>
void visit_outcome(Outcome& o, const Visit& visit) {
  visit(o.localized_after_s), visit(o.noticed_after_s), visit(o.tracked_before);
  for (auto* count : {&o.samples, &o.right, &o.confident_wrong, &o.false_lost, &o.since_localized,
                      &o.wrong_since, &o.nees_count})
    visit(*count);
  for (auto* number :
       {&o.confident_wrong_s, &o.right_s, &o.wrong_s, &o.missed_lost_s, &o.squared_error_m2, &o.nees_sum})
    visit(*number);
}
template <class Sample, class Visit>
void visit_sample(Sample& s, const Visit& visit) {
  for (auto* number : {&s.stamp_s, &s.position_error_m, &s.heading_error_rad, &s.x_error_m, &s.sigma_x_m,
                       &s.probability, &s.evidence, &s.log_odds, &s.share, &s.nees, &s.particles, &s.step_ms})
    visit(*number);
  visit(s.searched);
}
constexpr std::size_t kSampleBytes = 12 * 8 + 2;

}  // namespace

void put_trial(ByteWriter& w, const TrialResult& t) {
  const PutValue put{w};
  w.put(t.seed);
  for (const double number : {t.begun_s, t.start.x_m, t.start.y_m, t.start.theta_rad}) put(number);
  for (const std::size_t count : {t.searches, t.hits, t.unmapped}) put(count);
  visit_outcome(t.outcome, put);
  std::vector<std::uint32_t> marks;
  for (const SampleMark mark : t.marks) marks.push_back(mark.bits());
  w.put(marks);
  w.put_each(t.samples, [](ByteWriter& out, const TrialSample& s) {
    visit_sample(s, PutValue{out});
    out.put(static_cast<std::uint8_t>(s.state));
  });
}

TrialResult get_trial(ByteReader& r) {
  const GetValue get{r};
  TrialResult t;
  t.seed = r.get<std::uint64_t>();
  for (double* number : {&t.begun_s, &t.start.x_m, &t.start.y_m, &t.start.theta_rad}) get(*number);
  for (std::size_t* count : {&t.searches, &t.hits, &t.unmapped}) get(*count);
  visit_outcome(t.outcome, get);
  for (const std::optional<double>& after_s : {t.outcome.localized_after_s, t.outcome.noticed_after_s})
    r.expect(std::isfinite(after_s.value_or(0.0)), "a time");  // these are sorted
  for (const std::uint32_t bits : r.get_vector<std::uint32_t>()) t.marks.emplace_back(bits);
  t.samples = r.get_each(kSampleBytes, [](ByteReader& in) {
    TrialSample s;
    visit_sample(s, GetValue{in});
    const auto state = in.get<std::uint8_t>();
    in.expect(state <= static_cast<std::uint8_t>(HealthState::lost), "a state");
    s.state = static_cast<HealthState>(state);
    return s;
  });
  return t;
}

}  // namespace parloc::tools::shards
