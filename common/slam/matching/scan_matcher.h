// Maps that are drawn scan by scan, and scans that are matched to them, many in one call: what closing loops
// and odometry from scans ask of a backend.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/filter/steps/compute_config.h"
#include "common/math/pose.h"
#include "common/model/beams.h"
#include "common/slam/matching/map_tables.h"
#include "common/slam/matching/matching_stages.h"

namespace parloc {

/// How scans are drawn and matched (bind_matcher_rules of common/slam/slam_backend.h).
struct MatcherRules {
  DrawRules draw;
  MatchRules match;
  ClimbRules climb;
  double resolution_m = 0.05;  ///< Size of a cell.
};

struct ScanMatcherConfig {
  MatcherRules rules;
  int threads = 0;  ///< CPU: 0 is all cores.
  int device = 0;   ///< CUDA: index of the device.
};

/// A scan to be drawn; it must live until draw() returns.
struct ScanDrawing {
  std::size_t map = 0;
  const BeamTable* scan = nullptr;
  Pose pose;  ///< In the map's frame.
};

/// A scan to be matched; it must live until match() returns.
struct ScanQuery {
  std::size_t map = 0;
  const BeamTable* scan = nullptr;
  Pose start;          ///< In the map's frame.
  ClimbRules climb;    ///< Without halvings: only how well the scan fits at the start.
  SearchRules search;  ///< Before the climb; without any reach there is none.
};

/// Where it fits best.
struct ScanMatch {
  Pose pose;      ///< In the map's frame.
  float fit = 0;  ///< As FoundPose has it.
};

/// Deterministic: the same bits with every backend, at any number of threads. Not thread-safe.
class ScanMatcher {
 public:
  explicit ScanMatcher(const MatcherRules& rules) : rules_(rules) {}
  virtual ~ScanMatcher() = default;
  const MatcherRules& rules() const { return rules_; }

  /// Forgets all that was drawn; the memory is kept.
  virtual void clear() = 0;
  /// Draws scans into maps, which are there as soon as they are named: those of one map in their order.
  /// Throws Error{input} for poses so far apart that no map can have them.
  virtual void draw(const std::vector<ScanDrawing>& drawings) = 0;
  /// By query. In a map that nothing was drawn into nothing fits: the start, and a fit of 0.
  virtual std::vector<ScanMatch> match(const std::vector<ScanQuery>& queries) = 0;
  /// What was drawn. Its span holds at least what the scans of this map reach; of the only map, no more.
  virtual SlamCells cells(std::size_t map) = 0;

 private:
  MatcherRules rules_;
};

/// The window of a search so far around. Throws Error{config} for one that is too large.
SearchRules bind_search_rules(double resolution_m, double reach_m, double reach_rad, double bias);

/// For backends. The pose as maps have it, and back.
SlamPose slam_pose(const Pose& pose);
ScanMatch match_of(const FoundPose& found);
/// The query in the backend's memory, where its map and its scan are.
MatchTask bind_query(const ScanQuery& query, const TileMap& map, const Beams& scan,
                     const MatcherRules& rules);
/// A span that holds `span` and all that the scans reach.
TileSpan span_with(TileSpan span, const std::vector<ScanDrawing>& drawings, const DrawRules& rules);

/// Defined in cpu/match_scans.cpp and cuda/match_scans.cu. Throw as make_cpu_filter_backend and
/// make_cuda_filter_backend.
std::unique_ptr<ScanMatcher> make_cpu_scan_matcher(const ScanMatcherConfig& config);
std::unique_ptr<ScanMatcher> make_cuda_scan_matcher(const ScanMatcherConfig& config);
/// As make_filter_backend.
std::unique_ptr<ScanMatcher> make_scan_matcher(BackendChoice choice, const ScanMatcherConfig& config);

}  // namespace parloc
