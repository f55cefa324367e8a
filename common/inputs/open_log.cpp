#include "common/inputs/open_log.h"

#include "common/bag/open_bag.h"
#include "common/inputs/bag_log.h"

namespace parloc {

std::unique_ptr<LogReader> open_log(const std::string& path, const LogChoice& choice) {
  return is_bag(path) ? open_bag_log(path, choice) : open_carmen_log(path, choice.without_odometry);
}

}  // namespace parloc
