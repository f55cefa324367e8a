// A drive's results as bytes, bit for bit, for the file of a shard.
#pragma once

#include "common/eval/families/drive_score.h"
#include "common/file/bytes.h"

namespace parloc::tools::families {

void put_drive(ByteWriter& w, const DriveResult& drive);
/// Throws Error{input} for bytes that are none.
DriveResult get_drive(ByteReader& r);

}  // namespace parloc::tools::families
