#include "cpu/scan_chain.h"

#include <algorithm>

#include "common/filter/bind.h"
#include "cpu/draft_map.h"
#include "cpu/match_scan.h"

namespace parloc::cpu {
namespace {

// The local map is begun anew from the last `kKept` scans when it has `kMost`, as in ScanOdometry.
constexpr std::size_t kMost = 60, kKept = 30;
constexpr float kGoodFit = 0.6f;  // of the climbs from where particle and odometry say: no search is needed
constexpr double kStartsApart_m = 0.05;  // a cell: climbs from there may end elsewhere
constexpr float kLeastFit = 0.35f;       // below it the scan does not fit, and the particle's step is kept
constexpr double kReach_m = 0.4, kReach_rad = 0.3, kBias = 0.05;  // of the search where no climb fits well
constexpr double kMostCells = 20.0;                               // of its reach
constexpr float kLeastSearchFit = 0.5f;  // the wider the window, the more poses fit by chance ...
constexpr float kSearchGain = 0.15f;     // ... and by so much it must fit better

// Of a piece: some scans, over which a chain is sure to some centimetres.
constexpr double kPiece_m = 2.0;
constexpr std::size_t kMostInPiece = 40;  // where the robot turns on the spot

// Standard deviations of a step of the chain: the matcher's last moves are a millimetre, but walls are drawn
// in cells of some centimetres. Steps that fitted badly are surer of nothing.
constexpr double kStep_m = 0.02, kStep_rad = 0.005, kBadly = 3.0;
constexpr float kBadFit = 0.5f;

class Matcher {
 public:
  Matcher(const SlamConfig& c, const std::vector<BeamTable>& scans)
      : climb_{bind_propose_rules(c).match, {}, bind_propose_rules(c).climb},
        search_{climb_.match,
                bind_search_rules(c, std::min(kReach_m, kMostCells * c.resolution), kReach_rad, kBias),
                climb_.climb},
        scans_(scans),
        map_(bind_draw_rules(c), climb_.match) {}

  ScanMatch match(std::size_t k, const Pose& by_particle, const Pose& by_odometry) const {
    const Beams beams = bind_beams(scans_[k]);
    ScanMatch found = match_scan(climb_, map_.view(), beams, slam_pose(by_particle));
    if (found.fit < kGoodFit || distance_m(by_particle, by_odometry) > kStartsApart_m) {
      const ScanMatch other = match_scan(climb_, map_.view(), beams, slam_pose(by_odometry));
      if (other.fit > found.fit) found = other;
    }
    if (found.fit >= kGoodFit) return found;
    const ScanMatch searched = match_scan(search_, map_.view(), beams, slam_pose(by_particle));
    return searched.fit > std::max(kLeastSearchFit, found.fit + kSearchGain) ? searched : found;
  }
  /// After scan k, whose pose is known now.
  void draw(const std::vector<Pose>& pose, std::size_t k) {
    const bool anew = k - first_ >= kMost;
    if (anew) first_ = k - kKept, map_.clear();
    for (std::size_t i = anew ? first_ : k; i <= k; ++i) map_.draw(bind_beams(scans_[i]), slam_pose(pose[i]));
  }

 private:
  MatchScanRules climb_, search_;
  const std::vector<BeamTable>& scans_;
  DraftMap map_;
  std::size_t first_ = 0;
};

}  // namespace

ScanChain chain_scans(const SlamConfig& config, const ScannedPath& way,
                      const std::function<void(double fraction)>& watch) {
  const std::size_t count = way.path.size();
  ScanChain chain{{}, std::vector<float>(count, 1.0f), std::vector<double>(count, 0.0)};
  Matcher matcher(config, way.scans);
  for (std::size_t k = 0; k < count; ++k) {
    if (k == 0) {
      chain.pose.push_back(way.path[0]);
    } else {
      const Pose& last = chain.pose.back();
      const Pose by_particle = compose(last, relative(way.path[k], way.path[k - 1]));
      const Pose by_odometry = compose(last, relative(way.odometry[k], way.odometry[k - 1]));
      const ScanMatch found = matcher.match(k, by_particle, by_odometry);
      const Pose now = found.fit > kLeastFit ? pose_of(found.pose) : by_particle;
      chain.fit[k] = found.fit;
      chain.way_m[k] = chain.way_m[k - 1] + distance_m(last, now);
      chain.pose.push_back(now);
    }
    matcher.draw(chain.pose, k);
    if (watch) watch(static_cast<double>(k + 1) / static_cast<double>(count));
  }
  return chain;
}

std::vector<Piece> cut_in_pieces(const ScanChain& chain) {
  std::vector<Piece> pieces;
  for (std::size_t begin = 0; begin < chain.pose.size();) {
    std::size_t end = begin + 1;
    while (end < chain.pose.size() && end - begin < kMostInPiece &&
           chain.way_m[end] - chain.way_m[begin] < kPiece_m)
      ++end;
    pieces.push_back({begin, end, (begin + end) / 2});
    begin = end;
  }
  return pieces;
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

}  // namespace parloc::cpu
