// What stands around the content of a checkpoint; SlamCheckpoint checks it.
#pragma once

#include "common/file/bytes.h"

namespace parloc {

/// Magic and version. The content comes next: settings as YAML, the caller's own bytes, and the state.
void put_checkpoint_begin(ByteWriter& w);
/// The checksum.
void put_checkpoint_end(ByteWriter& w);

}  // namespace parloc
