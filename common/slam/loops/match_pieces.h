// A piece of the path against the maps of others: several scans at once, in windows as wide as the path
// between is uncertain.
#pragma once

#include <optional>
#include <vector>

#include "common/slam/loops/pose_graph.h"
#include "common/slam/loops/scan_chain.h"

namespace parloc {

class PieceMatcher {
 public:
  /// All must outlive it.
  PieceMatcher(const std::vector<BeamTable>& scans, const ScanChain& chain, const std::vector<Piece>& pieces,
               ScanMatcher& matcher);

  /// Where a piece is looked for: up to `reach_m` around `guess` along x and y, both seen from piece `from`.
  struct Window {
    std::size_t from;
    Pose guess;
    double reach_m;
  };
  struct Found {
    std::vector<ScanMatch> places;  ///< Of the piece seen from piece `from`, the best first.
    std::optional<PoseEdge> edge;   ///< The best, if it fits well and is the only one that does.
  };

  /// By window, where piece `b` was found.
  std::vector<Found> match(std::size_t b, const std::vector<Window>& windows) const;
  /// Whether another place of a piece speaks against the best one: elsewhere, and about as good.
  static bool rivals(const ScanMatch& best, const ScanMatch& other);

 private:
  BeamTable beams_of(std::size_t piece, std::size_t most) const;
  void draw_maps(const std::vector<Window>& windows) const;
  void search(const std::vector<Window>& windows, const BeamTable& beams, std::vector<Found>& found) const;
  void climb(const BeamTable& beams, std::vector<Found>& found) const;
  void ask(const std::vector<ScanQuery>& queries, std::vector<Found>& found) const;
  void add_edges(const std::vector<Window>& windows, std::size_t b, const BeamTable& beams,
                 std::vector<Found>& found) const;

  const std::vector<BeamTable>& scans_;
  const ScanChain& chain_;
  const std::vector<Piece>& pieces_;
  ScanMatcher& matcher_;
  double wide_m_;
  SearchRules wide_, narrow_;
};

}  // namespace parloc
