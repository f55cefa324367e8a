// How what there is to show of a growing map is written into a checkpoint and read from it.
#pragma once

#include "common/file/bytes.h"
#include "tools/slam/growth.h"

namespace parloc::tools::slam {

void put_growth(ByteWriter& w, const Growth& growth);
/// Throws Error{input}.
Growth get_growth(ByteReader& r);

}  // namespace parloc::tools::slam
