// A trial's result as bytes, bit for bit, for the file of a shard.
#pragma once

#include "common/eval/run_trial.h"
#include "common/file/bytes.h"

namespace parloc::tools::shards {

void put_trial(ByteWriter& w, const TrialResult& trial);
/// Throws Error{input} for bytes that are none.
TrialResult get_trial(ByteReader& r);

}  // namespace parloc::tools::shards
