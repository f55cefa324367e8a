#include "common/search/search_settings.h"

namespace parloc {

void add_settings(Settings& s, SearchConfig& search) {
  s.group("search", "The search of the whole map (docs/locate.md).");
  s.add("cell_m", "Finer cells of the map are put together to such [m]", search.cell_m, {0, 10, true});
  s.add("beams", "Hits that the exhaustive part looks at", search.beams, {1, 256});
  s.add("least_score", "How close hits end to walls, 0 to 1: below it a place is none", search.least_score,
        {0, 1});
  s.add("candidates", "Places that rays are cast for", search.candidates, {10, 10000});
}

}  // namespace parloc
