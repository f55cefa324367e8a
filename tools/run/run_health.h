// How sure a run was, from scan to scan and at its end.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tools/run/localize_log.h"

namespace parloc::tools {

struct RunHealth {
  std::size_t scans = 0, tracking = 0, ambiguous = 0, lost = 0;
  std::size_t searches = 0;
  std::vector<double> lost_s;  ///< Stamps at which it turned lost; a start anywhere does not count.
  Health last;
  std::vector<Mode> modes;  ///< At the end, while ambiguous.
};

/// Empty for a run that was not judged.
std::optional<RunHealth> run_health(const Localization& run);

/// "tracking 98.2 %, ambiguous 1.5 %, lost 0.3 % of the scans; searched 2 times"
std::string health_text(const RunHealth& health);

/// One line that says that the place at the end is not known; empty if it is, or if nobody judged.
std::string doubt_at_end(const Localization& run);

}  // namespace parloc::tools
