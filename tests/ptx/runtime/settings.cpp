#include "tests/ptx/runtime/settings.h"

#include <cstdlib>

namespace ptx {
namespace {

std::uint64_t number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace

Settings& settings() {
  const char* known = std::getenv("PTX_KNOWN_RACES");
  static Settings chosen{static_cast<std::uint32_t>(number("PTX_SEED", 1)),
                         number("PTX_RACES", 1) != 0,
                         number("PTX_LATE_COPIES", 0) != 0,
                         number("PTX_MEMORY_MB", 20000) << 20,
                         number("PTX_FAIL_ALLOCATION", 0),
                         known != nullptr ? known : "",
                         number("PTX_REPORT", 0) != 0};
  return chosen;
}

}  // namespace ptx
