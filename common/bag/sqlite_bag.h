// ROS 2 bags in SQLite files (.db3, schema versions 1 to 4 of rosbag2_storage_sqlite3).
#pragma once

#include <memory>
#include <string>

#include "common/bag/bag.h"

namespace parloc {

/// Messages may each be a zstd frame. A file that is cut off or damaged gives what can be reached. Throws
/// Error{input} if it has no table of topics and messages.
std::unique_ptr<BagReader> open_sqlite_bag(const std::string& path, const std::string& name);

}  // namespace parloc
