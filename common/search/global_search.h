// Where on the map can this scan have been taken? All poses of a lattice over the whole free space, the best
// of them found for certain (docs/locate.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/filter/steps/compute_config.h"
#include "common/filter/steps/step_config.h"
#include "common/map/grid_map.h"
#include "common/math/pose.h"
#include "common/model/beam_table.h"
#include "common/model/scan.h"
#include "common/search/search_config.h"

namespace parloc {

/// One place where the scan may have been taken. Shares are of all beams, hits and misses.
struct Hypothesis {
  Pose pose;               ///< Map frame.
  double score = 0.0;      ///< How close the hits end to walls, 0 to 1.
  double explained = 0.0;  ///< Share of beams that end where the map's ray does.
  double through = 0.0;    ///< Share of beams that go through a wall of the map.
  double unmapped = 0.0;   ///< Share of beams that end before the map's wall.
  double evidence = 0.0;   ///< What the scan says for it, against any other place [nat per beam].
  double weight = 0.0;     ///< Share among all hypotheses that were judged.
  bool as_good = false;    ///< As good as the first (which is, too).
};

/// What a search of the whole map has found.
struct SearchResult {
  std::vector<Hypothesis> hypotheses;  ///< The most likely first; separated; may be empty.
  bool ambiguous = false;  ///< Another one is as good as the first, or there were too many to judge them all.
  std::size_t beams = 0;   ///< Hits that the exhaustive part looked at.
  std::size_t headings = 0;    ///< Of the lattice.
  std::size_t candidates = 0;  ///< Separated lattice poses that were judged.
  bool too_many = false;       ///< There may be more than those.
};

/// Throws Error{config} for an impossible value.
void validate(const SearchConfig& config);

/// Not thread-safe; one object per map. Deterministic: the same map, configuration and beams give the same
/// bits on every backend, thread count and instruction set.
///
/// A search can be done in slices, between which something else is done:
///   search.begin(beams);
///   while (!search.advance(work)) { ... }
///   const SearchResult result = search.result();
class GlobalSearch {
 public:
  /// Everything that depends on the map alone. `compute`, which is no part of SearchConfig, is all cores of
  /// the CPU or the first CUDA device unless it is given: a filter's configuration is one, so that
  /// GlobalSearch(map, config.search, config) works where that filter does. Throws Error{input} for a map
  /// that is none (validate) or has no free cell, Error{config} for an impossible configuration,
  /// Error{backend} if the backend is not there.
  explicit GlobalSearch(const GridMap& map, const SearchConfig& config = {},
                        const ComputeConfig& compute = {});
  /// A second one of the same map, for searches while the first is under way: shares what depends on the map.
  /// cell_m and sigma_m are those of the first. `beside` may be null.
  GlobalSearch(const GridMap& map, const SearchConfig& config, const ComputeConfig& compute,
               const GlobalSearch* beside);
  ~GlobalSearch();
  GlobalSearch(GlobalSearch&&) noexcept;
  GlobalSearch& operator=(GlobalSearch&&) noexcept;

  /// `beams` as select_beams makes them for this map. Without a hit there is no hypothesis. Throws
  /// Error{input} for a prior that is not finite or leaves no free cell.
  SearchResult search(const BeamTable& beams, const SearchPrior& prior = {});
  /// The same for a scan taken in an instant; `config` says which beams count (scan) and where its LiDAR sits
  /// (lidars): that of a filter will do. Throws Error{input} also for a scan that makes no sense.
  SearchResult search(const Scan& scan, const StepConfig& config, const SearchPrior& prior = {});

  /// Begins a search to be done in slices; any other is given up. `beams` may be ParticleFilter::beams().
  /// Copies what it needs of `beams`. Takes far less than a millisecond, but for a region of many blocks none
  /// of which has a free cell. Throws as `search`; then none is under way.
  void begin(const BeamTable& beams, const SearchPrior& prior = {});
  /// Does about so much work, but something, and at most one piece more than asked for: a row of blocks at
  /// one heading, or the judging of one place. True when there is no more to do. The unit is one beam looked
  /// up for 64 blocks or poses at once, 1 to 3 ns on one core (search_work.h); a million of them is a slice
  /// of a few milliseconds. What is found does not depend on how the work is sliced, and how much work a
  /// search is depends neither on that nor on the backend, the threads or the machine: the same slices end it
  /// everywhere. Allocates nothing once memory has grown.
  bool advance(std::int64_t work);
  /// Whether a search was begun and is neither finished nor given up.
  bool under_way() const;
  /// Gives it up.
  void cancel();
  /// And forgets what was learnt of LiDARs: the next search takes as much work as if it were the first.
  void forget();
  /// Learns now what the first search of a LiDAR that reaches so far [m] would learn: as many milliseconds
  /// less for that.
  void learn(double range_max_m);
  /// Of the last search that was finished since `begin`. Throws Error{internal} if there is none.
  SearchResult result() const;
  /// All of the work that has been done since `begin`.
  std::int64_t work_done() const;

  std::string backend_name() const;           ///< As PoseFilter::backend_name().
  const std::string& backend_reason() const;  ///< One line on why this one was taken.

 private:
  friend class SearchParts;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parloc
