// Any bytes are a BMP image with all of its pixels, or an Error{input} of one line.
#include "tests/fuzz/image_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::check_image(parloc::read_bmp, data, size);
  return 0;
}
