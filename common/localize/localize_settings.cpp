#include "common/localize/localize_settings.h"

namespace parloc {

void add_settings(Settings& s, LocalizeConfig& localize) {
  s.group("localize", "What watches the filter, and what is done when it is lost (docs/localize.md).");
  s.add("health", "Say how sure the pose is; false: the bare filter, without any search", localize.health);
  s.add("recover", "Search the map when lost; false: only say so", localize.recover);
}

}  // namespace parloc
