// Opens a robot log, whatever its format.
#pragma once

#include <memory>
#include <string>

#include "common/io/log.h"

namespace parloc {

/// The one list of formats: today CARMEN text, plain or gzip (open_carmen_log). Throws Error{input} if the
/// file cannot be read.
inline std::unique_ptr<LogReader> open_log(const std::string& path) {
  return open_carmen_log(path);
}

}  // namespace parloc
