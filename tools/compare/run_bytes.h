// The runs of a seed as bytes, bit for bit, for the file of a shard.
#pragma once

#include <cstddef>

#include "common/file/bytes.h"
#include "tools/compare/run_all.h"

namespace parloc::tools::compare {

/// Of a seed whose runs are all there.
void put_seed(ByteWriter& w, const SeedRuns& runs);
/// Throws Error{input} for bytes that are none, or not of so many entries.
SeedRuns get_seed(ByteReader& r, std::size_t entries);

}  // namespace parloc::tools::compare
