#include "tools/bench/published.h"

#include <algorithm>

namespace parloc::tools::bench {

// Source: Paz, Perez Paina, Canali and Toloza 2012, the three tables of times per filter step, in seconds,
// rounded to 0.1 ms. The first machine is a dual core of which one core is used.
const std::array<PublishedTable, 3>& published_tables() {
  static const std::array<PublishedTable, 3> tables{{
      {"single_core",
       "dual core, 1 core, 2.13 GHz",
       {{{.0241, .0471, .0933},
         {.0488, .0949, .1870},
         {.1006, .1926, .3774},
         {.1562, .2942, .5707},
         {.2141, .3983, .7679}}}},
      {"gtx560",
       "GeForce GTX 560",
       {{{.0084, .0168, .0353},
         {.0164, .0324, .0671},
         {.0253, .0498, .1015},
         {.0339, .0671, .1306},
         {.0421, .0834, .1642}}}},
      {"opteron",
       "Opteron, 16 cores",
       {{{.0016, .0056, .0104},
         {.0069, .0121, .0210},
         {.0160, .0260, .0427},
         {.0281, .0420, .0692},
         {.0408, .0592, .0975}}}},
  }};
  return tables;
}

// Measured for parloc on one machine in one run; the inexact ones are range_libc's tables of ranges.
std::span<const PeerTime> peer_times() {
  using enum SensorModel;
  static constexpr PeerTime times[] = {{"nav2 (amcl)", beam, 1, 0.195},
                                       {"Beluga", beam, 2, 0.188},
                                       {"range_libc PCDDT", beam, 1, 0.0323},
                                       {"range_libc GLT, inexact", beam, 1, 0.00823},
                                       {"nav2 (amcl)", likelihood_field, 1, 0.0293},
                                       {"Beluga", likelihood_field, 2, 0.00311}};
  return times;
}

std::optional<double> published_seconds(const PublishedTable& table, std::int64_t particles, int beams) {
  const auto row = std::find(kPublishedParticles.begin(), kPublishedParticles.end(), particles);
  const auto column = std::find(kPublishedBeams.begin(), kPublishedBeams.end(), beams);
  if (row == kPublishedParticles.end() || column == kPublishedBeams.end()) return std::nullopt;
  return table.seconds[static_cast<std::size_t>(row - kPublishedParticles.begin())]
                      [static_cast<std::size_t>(column - kPublishedBeams.begin())];
}

}  // namespace parloc::tools::bench
