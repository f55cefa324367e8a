#include "common/slam/loops/scan_chain.h"

#include <algorithm>

namespace parloc {
namespace {

// The local map is begun anew from the last `kKeptScans` scans when it has `kMostScans`, as in ScanOdometry.
constexpr std::size_t kMostScans = 60, kKeptScans = 30;
constexpr float kGoodChainFit =
    0.6f;  // of the climbs from where particle and odometry say: no search is needed
constexpr double kStartsApart_m = 0.05;  // a cell: climbs from there may end elsewhere
constexpr float kLeastChainFit = 0.35f;  // below it the scan does not fit, and the particle's step is kept
constexpr double kChainReach_m = 0.4, kChainReach_rad = 0.3,
                 kChainBias = 0.05;  // of the search where no climb fits well
constexpr double kMostCells = 20.0;  // of its reach
// The wider the window, the more poses fit by chance: so well, and so much better, must a searched one fit.
constexpr float kLeastSearchFit = 0.5f, kSearchGain = 0.15f;

// Of a piece: some scans, over which a chain is sure to some centimetres.
constexpr double kPiece_m = 2.0;
constexpr std::size_t kMostInPiece = 40;  // where the robot turns on the spot

// Standard deviations of a step of the chain: the matcher's last moves are a millimetre, but walls are drawn
// in cells of some centimetres. Steps that fitted badly are surer of nothing.
constexpr double kStep_m = 0.02, kStep_rad = 0.005, kBadly = 3.0;
constexpr float kBadFit = 0.5f;

class Chainer {
 public:
  Chainer(const std::vector<BeamTable>& scans, ScanMatcher& matcher)
      : search_(bind_search_rules(matcher.rules().resolution_m,
                                  std::min(kChainReach_m, kMostCells * matcher.rules().resolution_m),
                                  kChainReach_rad, kChainBias)),
        scans_(scans),
        matcher_(matcher) {
    matcher_.clear();
  }

  ScanMatch match(std::size_t k, const Pose& by_particle, const Pose& by_odometry) {
    ScanMatch found = match_from(k, by_particle, {});
    if (found.fit < kGoodChainFit || distance_m(by_particle, by_odometry) > kStartsApart_m) {
      const ScanMatch other = match_from(k, by_odometry, {});
      if (other.fit > found.fit) found = other;
    }
    if (found.fit >= kGoodChainFit) return found;
    const ScanMatch searched = match_from(k, by_particle, search_);
    return searched.fit > std::max(kLeastSearchFit, found.fit + kSearchGain) ? searched : found;
  }
  /// After scan k, whose pose is known now.
  void draw(const std::vector<Pose>& pose, std::size_t k) {
    const bool anew = k - first_ >= kMostScans;
    if (anew) first_ = k - kKeptScans, matcher_.clear();
    std::vector<ScanDrawing> drawings;
    for (std::size_t i = anew ? first_ : k; i <= k; ++i) drawings.push_back({0, &scans_[i], pose[i]});
    matcher_.draw(drawings);
  }

 private:
  ScanMatch match_from(std::size_t k, const Pose& start, const SearchRules& search) {
    return matcher_.match({{0, &scans_[k], start, matcher_.rules().climb, search}})[0];
  }

  SearchRules search_;
  const std::vector<BeamTable>& scans_;
  ScanMatcher& matcher_;
  std::size_t first_ = 0;
};

}  // namespace

ScanChain chain_scans(const ScannedPath& scanned, ScanMatcher& matcher,
                      const std::function<void(double fraction)>& watch) {
  const std::vector<Pose>&path = scanned.path, &odometry = scanned.odometry;
  ScanChain chain{{}, std::vector<float>(path.size(), 1.0f), std::vector<double>(path.size(), 0.0)};
  Chainer chainer(scanned.scans, matcher);
  for (std::size_t k = 0; k < path.size(); ++k) {
    if (k == 0) {
      chain.pose.push_back(path[0]);
    } else {
      const Pose last = chain.pose.back();
      const Pose by_particle = compose(last, relative(path[k], path[k - 1]));
      const Pose by_odometry = compose(last, relative(odometry[k], odometry[k - 1]));
      const ScanMatch found = chainer.match(k, by_particle, by_odometry);
      chain.pose.push_back(found.fit > kLeastChainFit ? found.pose : by_particle);
      chain.fit[k] = found.fit;
      chain.travelled_m[k] = chain.travelled_m[k - 1] + distance_m(last, chain.pose[k]);
    }
    chainer.draw(chain.pose, k);
    if (watch) watch(static_cast<double>(k + 1) / static_cast<double>(path.size()));
  }
  return chain;
}

std::vector<Piece> cut_in_pieces(const ScanChain& chain) {
  std::vector<Piece> pieces;
  for (std::size_t begin = 0; begin < chain.pose.size();) {
    std::size_t end = begin + 1;
    while (end < chain.pose.size() && end - begin < kMostInPiece &&
           chain.travelled_m[end] - chain.travelled_m[begin] < kPiece_m)
      ++end;
    pieces.push_back({begin, end, (begin + end) / 2});
    begin = end;
  }
  return pieces;
}

Piece with_neighbours(const std::vector<Piece>& pieces, std::size_t piece) {
  const std::size_t first = piece > 0 ? piece - 1 : piece, last = std::min(piece + 1, pieces.size() - 1);
  return {pieces[first].begin, pieces[last].end, pieces[piece].middle};
}

Matrix3 chain_covariance(const ScanChain& chain, std::size_t from, std::size_t to) {
  Matrix3 sum;
  const Pose end = relative(chain.pose[to], chain.pose[from]);
  for (std::size_t k = from + 1; k <= to; ++k) {
    const Pose here = relative(chain.pose[k], chain.pose[from]);
    const double factor = chain.fit[k] < kBadFit ? kBadly : 1.0;
    const double step = factor * kStep_m, turn = factor * kStep_rad;
    Matrix3 lever = identity3();  // a turn here moves the end
    lever(0, 2) = here.y_m - end.y_m, lever(1, 2) = end.x_m - here.x_m;
    const Matrix3 part = sandwich(lever, diagonal3(step * step, step * step, turn * turn));
    for (int i = 0; i < 9; ++i) sum.m[i] += part.m[i];
  }
  return sum;
}

}  // namespace parloc
