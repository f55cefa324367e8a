#include "tools/evaluate/families/drive_bytes.h"

#include <cstdint>
#include <string>
#include <utility>

#include "tools/shards/trial_bytes.h"
#include "tools/shards/value_bytes.h"

namespace parloc::tools::families {
namespace {

using shards::GetValue, shards::PutValue;

/// The fields in the order of the bytes; `visit` puts or gets one.
template <class Score, class Visit>
void visit_score(Score& s, const Visit& visit) {
  for (auto* count : {&s.samples, &s.late, &s.late_sure_wrong, &s.searches}) visit(*count);
  for (auto* number : {&s.rmse_m, &s.largest_m, &s.largest_rad, &s.within, &s.sure_wrong_s,
                       &s.longest_sure_wrong_s, &s.nees_mean, &s.last_x_error_m, &s.last_sigma_x_m})
    visit(*number);
  for (auto& share : s.by_state) visit(share);
  visit(s.localized_after_s), visit(s.noticed_after_s);
}
template <class Drive, class Visit>
void visit_drive(Drive& d, const Visit& visit) {
  visit(d.family), visit(d.place), visit(d.events), visit(d.driven_s);
  visit_score(d.closed_score, visit), visit_score(d.bare_score, visit);
  visit(d.comparison.applies), visit(d.comparison.kept);
}

}  // namespace

void put_drive(ByteWriter& w, const DriveResult& d) {
  w.put(d.seed);
  visit_drive(d, PutValue{w});
  w.put_each(d.parameters, [](ByteWriter& out, const std::pair<std::string, double>& parameter) {
    out.put_text(parameter.first);
    out.put(parameter.second);
  });
  shards::put_trial(w, d.closed);
  shards::put_trial(w, d.bare);
}

DriveResult get_drive(ByteReader& r) {
  DriveResult d;
  d.seed = r.get<std::uint64_t>();
  visit_drive(d, GetValue{r});
  d.parameters = r.get_each(16, [](ByteReader& in) {
    std::string name = in.get_text();
    return std::pair(std::move(name), in.get<double>());
  });
  d.closed = shards::get_trial(r);
  d.bare = shards::get_trial(r);
  return d;
}

}  // namespace parloc::tools::families
