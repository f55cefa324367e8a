// ROS 1 bags, format 2.0 (wiki.ros.org/Bags/Format/2.0).
#pragma once

#include <memory>

#include "common/bag/bag.h"
#include "common/bag/bytes/byte_stream.h"

namespace parloc {

/// With or without an index, and with one whose lengths are wrong. Compressions none, lz4 and bz2. Throws
/// Error{input} for another version of the format.
std::unique_ptr<BagReader> open_ros1_bag(std::unique_ptr<BagFile> file);

}  // namespace parloc
