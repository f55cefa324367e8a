// Opens a recording, whatever its container.
#pragma once

#include <memory>
#include <string>

#include "common/bag/bag.h"

namespace parloc {

/// Whether the path is a folder, or begins as a bag does: by content, whatever the name.
bool is_bag(const std::string& path);

/// A folder of rosbag2 with or without metadata.yaml (its files one after the other), or one file: ROS 1,
/// SQLite or MCAP, as it is or as a whole compressed by zstd (unpacked to a temporary file, at most 1000
/// times as large). Throws Error{input} if there is nothing that can be read.
std::unique_ptr<BagReader> open_bag(const std::string& path);

}  // namespace parloc
