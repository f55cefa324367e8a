#include "common/localize/localize_settings.h"

namespace parloc {

void add_settings(Settings& s, LocalizeConfig& localize) {
  s.group("localize", "What watches the filter, and what is done when it is lost (docs/localize.md).");
  s.add("health", "Say how sure the pose is; false: the bare filter, without any search", localize.health);
  s.add("slips", "Look around the prediction when a scan does not fit it", localize.slips);
  s.add("recover", "Search the map when lost; false: only say so", localize.recover);
  s.add("carried_per_hour", "How often the robot is carried away [1/h]: what it takes to believe it",
        localize.carried_per_hour, {0, 1000, true});
  s.add("first_search_at_once", "false: in slices as every other search, the place being unknown until then",
        localize.first_search_at_once);
  s.add("search_slice", "Most work of a search beside one scan [million; 2 to 3 ms each on a core]",
        localize.search_slice, {0.01, 1000});
}

}  // namespace parloc
