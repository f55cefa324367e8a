// Any text is a configuration or an Error{config}; a configuration prints as text that reads back as itself.
#include "common/config/config.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace parloc;
  std::string printed;
  const auto read = [&] { printed = config_to_yaml(config_from_text(fuzz::text_of(data, size), "fuzz")); };
  // What was accepted and printed must be accepted again.
  if (fuzz::reads_or_says_why(ErrorKind::config, read))
    fuzz::require(config_to_yaml(config_from_text(printed, "printed")) == printed);
  return 0;
}
