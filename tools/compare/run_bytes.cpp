#include "tools/compare/run_bytes.h"

#include <cstdint>

#include "tools/shards/value_bytes.h"

namespace parloc::tools::compare {
namespace {

using shards::GetValue, shards::PutValue;

/// The numbers in the order of the bytes; `visit` puts or gets one.
template <class Run, class Visit>
void visit_run(Run& r, const Visit& visit) {
  auto& e = r.errors;
  for (auto* count : {&e.compared, &e.without_truth, &r.scans, &r.skipped}) visit(*count);
  for (auto* number : {&e.position_rmse_m, &e.position_mae_m, &e.position_max_m, &e.position_p95_m,
                       &e.heading_rmse_rad, &e.heading_mae_rad, &e.heading_max_rad, &e.x_rmse_m, &e.y_rmse_m,
                       &r.nees, &r.final_m, &r.away, &r.particles, &r.driven_s, &r.working_s})
    visit(*number);
  visit(r.found_s), visit(r.lost_s);
}

constexpr auto kSeries = {&TrackErrors::stamp_s, &TrackErrors::x_error_m, &TrackErrors::y_error_m,
                          &TrackErrors::position_error_m, &TrackErrors::heading_error_rad};
constexpr std::size_t kLeastRunBytes = 8 * (1 + 4 + 15 + 2 + 5 + 1);

void put_run(ByteWriter& w, const FilterRun& run) {
  w.put(run.seed);
  visit_run(run, PutValue{w});
  for (const auto series : kSeries) w.put(run.errors.*series);
  w.put(run.step_s);
}

FilterRun get_run(ByteReader& r) {
  FilterRun run;
  run.seed = r.get<std::uint64_t>();
  visit_run(run, GetValue{r});
  for (const auto series : kSeries) {
    run.errors.*series = r.get_vector<double>();
    r.expect((run.errors.*series).size() == run.errors.compared, "as many errors as scans");
  }
  run.step_s = r.get_vector<double>();
  return run;
}

}  // namespace

void put_seed(ByteWriter& w, const SeedRuns& seed) {
  w.put_count(seed.hits), w.put_count(seed.unmapped);
  w.put_each(seed.backends, [](ByteWriter& out, const std::string& name) { out.put_text(name); });
  w.put_each(seed.runs,
             [](ByteWriter& out, const std::optional<FilterRun>& run) { put_run(out, run.value()); });
}

SeedRuns get_seed(ByteReader& r, std::size_t entries) {
  SeedRuns seed;
  seed.hits = r.get<std::uint64_t>(), seed.unmapped = r.get<std::uint64_t>();
  seed.backends = r.get_each(8, [](ByteReader& in) { return in.get_text(); });
  seed.runs = r.get_each(kLeastRunBytes, [](ByteReader& in) { return std::optional(get_run(in)); });
  r.expect(seed.runs.size() == entries && seed.backends.size() == entries, "runs of every filter");
  return seed;
}

}  // namespace parloc::tools::compare
