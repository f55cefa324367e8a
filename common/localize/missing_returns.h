// How many beams of a LiDAR come to nothing wherever it is: on dark or shiny walls, in sunlight.
#pragma once

#include <vector>

#include "common/model/beams.h"

namespace parloc {

/// Learns the share of a drive's beams that are lost, whatever the map says: a beam between two that hit at
/// much the same range should have hit, too. Deterministic on every machine.
class MissingReturns {
 public:
  /// `novelty`: how much of the scan is new, 0 to 1 (ScanNovelty).
  void add(const BeamTable& beams, double novelty);
  double share() const { return lost_ / asked_; }

 private:
  struct Beam {
    double bearing_rad, range_m;
    bool hit;
  };
  double lost_ = 0.0, asked_ = 20.0;  // of so many none, to begin with
  std::vector<Beam> around_;          // of the scan at hand
};

}  // namespace parloc
