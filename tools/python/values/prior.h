// What is known beforehand of where the robot is.
#pragma once

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>

#include <array>
#include <optional>

#include "common/search/search_config.h"

namespace parloc::python {

using Disc = std::optional<std::array<double, 3>>;
using Interval = std::optional<std::array<double, 2>>;

inline SearchPrior prior_from(const Disc& region, const Interval& heading) {
  SearchPrior prior;
  if (region) prior.region = {(*region)[0], (*region)[1], (*region)[2]};
  if (heading) prior.heading = {(*heading)[0], (*heading)[1]};
  return prior;
}
inline constexpr const char* kPriorText =
    "`region` is (x_m, y_m, radius_m) in the map frame, `heading` is (heading_rad, tolerance_rad): what is "
    "not given may "
    "be anything.";

}  // namespace parloc::python
