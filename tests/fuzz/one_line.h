// What every reader must hold: any bytes are read, or are an Error of its kind that says what is wrong in one
// line.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <utility>

#include "common/error.h"

namespace parloc::fuzz {

inline void require(bool holds) {
  if (!holds) std::abort();
}

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Whether `read` ended without an error.
template <class Read>
bool reads_or_says_why(ErrorKind kind, Read&& read) {
  try {
    std::forward<Read>(read)();
    return true;
  } catch (const Error& e) {
    require(e.kind() == kind && std::string(e.what()).find('\n') == std::string::npos);
    return false;
  }
}

}  // namespace parloc::fuzz
