#include "common/io/open_truth.h"

#include "common/bag/open_bag.h"
#include "common/io/bag_truth.h"
#include "common/io/trajectory.h"

namespace parloc {

Trajectory open_truth(const std::string& path, const LogChoice& choice) {
  return is_bag(path) ? read_bag_truth(path, choice) : read_tum(path);
}

}  // namespace parloc
