// Reading a file whole, with one clear line when that fails.
#pragma once

#include <cstdint>
#include <string>

namespace parloc {

inline constexpr std::uintmax_t kWholeFile = static_cast<std::uintmax_t>(-1);

/// The file, but at most its first `longest` bytes. Throws Error{input} with `where` in front of the reason;
/// a folder or a device is not read.
std::string read_input_file(const std::string& path, const std::string& where,
                            std::uintmax_t longest = kWholeFile);

}  // namespace parloc
