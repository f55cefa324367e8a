// Opens a robot log, whatever its format.
#pragma once

#include <memory>
#include <string>

#include "common/io/log.h"
#include "common/io/log_choice.h"

namespace parloc {

/// The one list of formats, told apart by content: bags of ROS 1 and 2 (a folder, SQLite, MCAP, bag 2.0),
/// else CARMEN text, plain or gzip. Throws Error{input} if the file cannot be read, or a bag does not have
/// what `choice` wants.
std::unique_ptr<LogReader> open_log(const std::string& path, const LogChoice& choice = {});

}  // namespace parloc
