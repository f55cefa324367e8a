#include "tools/bench/steps/bisect.h"

#include <algorithm>
#include <cmath>

namespace parloc::tools::bench {

std::optional<Bracket> largest_that_fits(std::int64_t least, std::int64_t most, std::int64_t guess,
                                         double tolerance,
                                         const std::function<std::optional<bool>(std::int64_t)>& fits) {
  Bracket b;
  std::int64_t next = std::clamp(guess, least, most);
  for (;;) {
    const std::optional<bool> answer = fits(next);
    if (!answer) return std::nullopt;
    (*answer ? b.fits : b.too_many) = next;
    if (b.fits == most || b.too_many == least) return b;
    if (b.fits == 0) {
      next = std::max(least, b.too_many / 2);
    } else if (b.too_many == 0) {
      next = std::min(most, 2 * b.fits);
    } else {
      if (static_cast<double>(b.too_many) <= (1.0 + tolerance) * static_cast<double>(b.fits)) return b;
      if (b.too_many - b.fits <= 1) return b;
      const double middle = std::sqrt(static_cast<double>(b.fits) * static_cast<double>(b.too_many));
      next = std::clamp(static_cast<std::int64_t>(middle), b.fits + 1, b.too_many - 1);
    }
  }
}

}  // namespace parloc::tools::bench
