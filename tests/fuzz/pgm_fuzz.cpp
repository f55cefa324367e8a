// Any bytes are a PGM image with all of its pixels, or an Error{input} of one line.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/error.h"
#include "common/map/map_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const parloc::GreyImage image = parloc::read_pgm(data, size, "fuzz");
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (pixels == 0 || image.pixels.size() != pixels) std::abort();
    if (!image.alpha.empty() && image.alpha.size() != pixels) std::abort();
  } catch (const parloc::Error& e) {
    if (e.kind() != parloc::ErrorKind::input) std::abort();
    if (std::string(e.what()).find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
