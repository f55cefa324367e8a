// Any text is a configuration or an Error{config}; a configuration prints as text that reads back as itself.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/config/config.h"
#include "common/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string printed;
  try {
    printed = parloc::config_to_yaml(parloc::config_from_text(text, "fuzz"));
  } catch (const parloc::Error& e) {
    if (e.kind() != parloc::ErrorKind::config) std::abort();
    if (std::string(e.what()).find('\n') != std::string::npos) std::abort();  // one line
    return 0;
  }
  // Outside the try: what was accepted and printed must be accepted again.
  if (parloc::config_to_yaml(parloc::config_from_text(printed, "printed")) != printed) std::abort();
  return 0;
}
