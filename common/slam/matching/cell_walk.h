// The cells that a beam passes (Amanatides and Woo 1987; SPEC 2.2): as many steps along each axis as its ends
// are apart, so that it ends in the cell of its end point.
#pragma once

#include <cstdint>

#include "common/map/rays/ray_cast.h"

namespace parloc {

class CellWalk {
 public:
  /// From (u0, v0) to (u1, v1) [cells].
  PARLOC_HD CellWalk(float u0, float v0, float u1, float v1)
      : ray_(make_ray(u0, v0, u1 - u0, v1 - v0)),
        i_(static_cast<std::int32_t>(floor_of(u0))),
        j_(static_cast<std::int32_t>(floor_of(v0))) {
    const std::int32_t di = static_cast<std::int32_t>(floor_of(u1)) - i_;
    const std::int32_t dj = static_cast<std::int32_t>(floor_of(v1)) - j_;
    step_i_ = di < 0 ? -1 : 1, step_j_ = dj < 0 ? -1 : 1;
    left_i_ = di < 0 ? -di : di, left_j_ = dj < 0 ? -dj : dj;
  }
  PARLOC_HD std::int32_t i() const { return i_; }
  PARLOC_HD std::int32_t j() const { return j_; }
  /// This is the last cell.
  PARLOC_HD bool at_end() const { return left_i_ + left_j_ == 0; }
  PARLOC_HD void step() {
    const float ti = (static_cast<float>(step_i_ < 0 ? i_ : i_ + 1) - ray_.u) * ray_.inv_dx;
    const float tj = (static_cast<float>(step_j_ < 0 ? j_ : j_ + 1) - ray_.v) * ray_.inv_dy;
    const bool along_i = left_j_ == 0 || (left_i_ > 0 && ti < tj);
    i_ += along_i ? step_i_ : 0, left_i_ -= along_i ? 1 : 0;
    j_ += along_i ? 0 : step_j_, left_j_ -= along_i ? 0 : 1;
  }

 private:
  Ray ray_;
  std::int32_t i_, j_, step_i_, step_j_, left_i_, left_j_;
};

}  // namespace parloc
