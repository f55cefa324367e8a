// The largest size that fits, found by asking.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace parloc::tools::bench {

struct Bracket {
  std::int64_t fits = 0;      ///< The largest that was found to fit; 0: none was.
  std::int64_t too_many = 0;  ///< The smallest that was found not to fit; 0: none was.
};

/// Of sizes from `least` to `most`: doubles or halves from `guess` until one fits and one does not, then
/// halves the distance (geometrically) until it is within `tolerance` (0.03: 3 %). `fits` gives empty to end
/// the search; then the answer is empty too.
std::optional<Bracket> largest_that_fits(std::int64_t least, std::int64_t most, std::int64_t guess,
                                         double tolerance,
                                         const std::function<std::optional<bool>(std::int64_t)>& fits);

}  // namespace parloc::tools::bench
