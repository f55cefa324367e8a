// Whether a measurement fits in the machine's memory, asked before it is begun: a system that overcommits
// would end the program instead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/bench/steps/variants.h"

namespace parloc::tools::bench {

/// Host memory that this program may still take: what the kernel says is available, within the limits of its
/// control group and of the shell (ulimit -v). Empty if nothing is known.
std::optional<std::uint64_t> available_bytes();

/// Host memory of a rig with so many particles, map and tables included.
std::uint64_t needed_bytes(const Variant& variant, std::int64_t particles);

/// The largest number up to `most` for which that is available.
std::int64_t particles_in_memory(const Variant& variant, std::int64_t most,
                                 std::optional<std::uint64_t> available);

/// Why so many particles cannot be measured here; empty if they can.
std::string too_large(const Variant& variant, std::int64_t particles, std::optional<std::uint64_t> available);

}  // namespace parloc::tools::bench
