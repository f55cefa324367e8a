#include "common/io/open_log.h"

namespace parloc {

std::unique_ptr<LogReader> open_log(const std::string& path) {
  return open_carmen_log(path);
}

}  // namespace parloc
