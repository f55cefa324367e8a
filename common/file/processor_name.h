// What a machine's processor is called, for people who read results.
#pragma once

#include <istream>
#include <string>

namespace parloc {

/// Of the machine that this runs on.
std::string processor_name();

/// Out of what /proc/cpuinfo holds: the model's name on x86, on ARM the kinds of its cores, with `board`,
/// where that is known.
std::string processor_name(std::istream& cpuinfo, const std::string& board);

}  // namespace parloc
