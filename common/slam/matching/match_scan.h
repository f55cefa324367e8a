// Where a scan fits best: the best pose of a window, where one is to be searched, then a climb from there.
// Like its two parts it asks for sums over beams; who adds them up is the backend's affair.
#pragma once

#include "common/slam/matching/hill_climb.h"
#include "common/slam/matching/wide_search.h"

namespace parloc {

/// What a search for a pose asks of the map: sums over the beams of a scan.
enum class Ask {
  score,       ///< How many beams fit [1/65536].
  likelihood,  ///< Log-likelihood [nat / 65536].
  bound,       ///< No pose of a block of WideSearch has a higher score.
};

/// Over every `step`-th beam from `first` on.
PARLOC_HD std::int32_t sum_beams(const TileMap& map, const Beams& beams, const MatchPose& pose,
                                 const MatchRules& rules, Ask ask, std::size_t first, std::size_t step) {
  std::int32_t sum = 0;
  if (ask == Ask::score) {
    for (std::size_t m = first; m < beams.hits; m += step)
      sum += match_term(map, beams, m, pose, rules, ScoreTerm{});
  } else if (ask == Ask::likelihood) {
    for (std::size_t m = first; m < beams.hits; m += step)
      sum += match_term(map, beams, m, pose, rules, LikelihoodTerm{});
  } else {
    for (std::size_t m = first; m < beams.hits; m += step) sum += block_term(map, beams, m, pose, rules);
  }
  return sum;
}

struct ScanSearchRules {
  SearchRules search;     ///< Without any reach nothing is searched.
  ClimbRules climb;       ///< Without halvings it ends where it starts, whose score is then known.
  std::size_t beams = 0;  ///< That are matched (count_matched).
};

class ScanSearch {
 public:
  static constexpr int kMostPoses = WideSearch::kBatch;  ///< Asked for at once.
  static_assert(WideSearch::kBlock * WideSearch::kBlock <= kMostPoses);
  PARLOC_HD static int most_rounds(const SearchRules& r) {
    return HillClimb::kMostRounds + (r.any() ? WideSearch::kMostRounds : 0);
  }

  PARLOC_HD void begin(const SlamPose& start, const ScanSearchRules& r) {
    searches_ = r.search.any();
    window_.begin(start, r.search, r.beams);
    climb_.begin(start, r.climb, r.beams);
  }
  PARLOC_HD bool done() const { return !searches_ && climb_.done(); }
  PARLOC_HD Ask ask() const { return searches_ && window_.asks_bounds() ? Ask::bound : Ask::score; }
  PARLOC_HD int wanted() const { return searches_ ? window_.wanted() : climb_.wanted(); }
  PARLOC_HD SlamPose candidate(int k, const ScanSearchRules& r) const {
    return searches_ ? window_.candidate(k, r.search) : climb_.candidate(k);
  }
  /// `bound`: room for WideSearch::kMostBlocks, kept from call to call.
  PARLOC_HD void take(const std::int32_t* sum, std::int32_t* bound, const ScanSearchRules& r) {
    if (!searches_) return climb_.take(sum);
    window_.take(sum, bound, r.search);
    if (!window_.done()) return;
    searches_ = false;
    climb_.begin(window_.pose(), r.climb, r.beams);
  }
  PARLOC_HD const SlamPose& pose() const { return climb_.pose(); }
  PARLOC_HD std::int32_t score() const { return climb_.score(); }

 private:
  WideSearch window_;
  HillClimb climb_;
  bool searches_ = false;
};

/// Beams that a score is the sum of.
PARLOC_HD std::size_t count_matched(const float* range_m, std::size_t hits, const MatchRules& rules) {
  std::size_t matched = 0;
  for (std::size_t m = 0; m < hits; ++m) matched += range_m[m] <= rules.usable_m ? 1 : 0;
  return matched;
}

}  // namespace parloc
