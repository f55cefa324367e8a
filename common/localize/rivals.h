// Places where the robot may have been carried to, weighed against the one that is tracked.
#pragma once

#include <cstddef>
#include <vector>

#include "common/localize/modes.h"
#include "common/localize/place_evidence.h"
#include "common/localize/slip_search.h"
#include "common/math/pose.h"
#include "common/model/beams.h"

namespace parloc {

/// Places with a smaller share of the belief do not matter.
inline constexpr double kNoMatter = 0.01;

/// To have been carried away is a hypothesis with a price: it is rare, and among many places one will always
/// look well. What the same scans say of both places must pay it: those since the doubt began, of which some
/// are later than the one that the place was found by, which fits it by choice. So beams that no place
/// explains speak for none. Deterministic on every machine.
class Rivals {
 public:
  void clear() { *this = {}; }
  bool empty() const { return poses_.empty(); }

  /// Takes those of a search that explain their scan. `places`: how many it had to choose from.
  void begin(const std::vector<JudgedPlace>& found, std::size_t places, const Pose& odometry);
  /// Moves them by the odometry. After some metres without a decision they are given up.
  void follow(const Pose& odometry);
  /// With a scan that `judge` has just remembered: those that have paid the price, the most likely first,
  /// with their evidence and their shares. `tracked` are the places that the filter stands for.
  std::vector<JudgedPlace> weigh(const std::vector<Mode>& tracked, const BeamTable& beams,
                                 PlaceEvidence& judge, SlipSearch& near_by, double carried_per_hour);

 private:
  std::vector<Pose> poses_;  // where the robot would be now
  Pose odometry_, found_;    // of these poses; where they were found
  std::size_t places_ = 0, scans_ = 0;
};

}  // namespace parloc
