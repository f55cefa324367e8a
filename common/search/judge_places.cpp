#include "common/search/judge_places.h"

#include <algorithm>

#include "common/math/portable.h"
#include "common/math/portable64.h"
#include "common/search/search_work.h"

namespace parloc {

JudgePlaces::JudgePlaces(const GridMap& map, const SearchMap& search, const SearchConfig& config)
    : config_(config), T_map_grid_(map.T_map_grid), cell_m_(search.cell_m), evidence_(map, search) {}

void JudgePlaces::begin(const BeamTable& beams, const std::vector<LatticePose>& places,
                        std::int32_t headings) {
  beams_ = &beams;
  places_ = &places;
  headings_ = headings;
  to_learn_ = places.empty() ? 0 : evidence_.learn(beams.range_max_m, 0);
  judged_.clear();
  order_.clear();
  kept_.clear();
  ranked_ = 0;
  total_weight_ = 0.0;
}

bool JudgePlaces::done() const {
  return judged_.size() == places_->size() && ranked_ == judged_.size();
}

std::int64_t JudgePlaces::advance(std::int64_t work) {
  std::int64_t spent = 0;
  while (!done() && (spent == 0 || spent < work)) spent += step(work - spent);
  return spent;
}

std::int64_t JudgePlaces::step(std::int64_t work) {
  if (to_learn_ > 0) {
    const std::size_t before = to_learn_;
    const std::int64_t places =
        std::clamp<std::int64_t>(work / search_work::kChancePlace, 1, ScanEvidence::kPlaces);
    to_learn_ = evidence_.learn(beams_->range_max_m, static_cast<std::size_t>(places));
    return static_cast<std::int64_t>(before - to_learn_) * search_work::kChancePlace;
  }
  return judged_.size() < places_->size() ? judge_next() : rank_next();
}

std::int64_t JudgePlaces::judge_next() {
  Pose pose = pose_of((*places_)[judged_.size()], headings_, cell_m_);
  Hypothesis h;
  std::int64_t tried = 0;
  h.score = evidence_.refine(*beams_, 2.0 * kPi / headings_, pose, tried);
  const PoseVerdict verdict = evidence_.judge(*beams_, pose);
  h.explained = verdict.explained;
  h.through = verdict.through;
  h.unmapped = verdict.unmapped;
  h.evidence = verdict.evidence;
  h.pose = compose(T_map_grid_, pose);
  const auto more_likely = [&](double evidence, std::uint32_t n) { return evidence > judged_[n].evidence; };
  const auto place = std::upper_bound(order_.begin(), order_.end(), h.evidence, more_likely);
  order_.insert(place, static_cast<std::uint32_t>(judged_.size()));
  judged_.push_back(h);
  return tried * static_cast<std::int64_t>(beams_->hits) * search_work::kFieldBeam +
         static_cast<std::int64_t>(beams_->count) * search_work::kRay;
}

/// Weights are relative to the best until they are reported.
std::int64_t JudgePlaces::rank_next() {
  Hypothesis h = judged_[order_[ranked_++]];
  const auto compared = static_cast<std::int64_t>(kept_.size());
  const Separation separation{config_.separation_m, config_.separation_rad};
  const auto apart = [&](const Hypothesis& other) { return separated(h.pose, other.pose, separation); };
  if (std::all_of(kept_.begin(), kept_.end(), apart)) {
    const double behind = h.evidence - judged_[order_[0]].evidence;
    h.weight = portable_exp(static_cast<float>(config_.effective_beams * behind));
    total_weight_ += h.weight;
    kept_.push_back(h);
  }
  return 1 + search_work::kComparedPose * compared;
}

void JudgePlaces::report(SearchResult& result) const {
  result.candidates = places_->size();
  result.too_many = result.candidates == static_cast<std::size_t>(config_.candidates);
  result.ambiguous = result.too_many;
  const std::size_t most = static_cast<std::size_t>(config_.most);
  for (std::size_t n = 0; n < kept_.size(); ++n) {
    Hypothesis h = kept_[n];
    h.weight /= total_weight_;
    h.as_good = h.weight >= config_.ambiguous_share * (kept_[0].weight / total_weight_);
    result.ambiguous = result.ambiguous || (n > 0 && h.as_good);
    if (n < most) result.hypotheses.push_back(h);
  }
}

}  // namespace parloc
