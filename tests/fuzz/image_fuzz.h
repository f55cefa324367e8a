// What every image reader must hold: any bytes are an image with all of its pixels, or an Error{input} of one
// line.
#pragma once

#include "common/map/map_reader.h"
#include "tests/fuzz/one_line.h"

namespace parloc::fuzz {

using ImageReader = GreyImage (*)(const std::uint8_t* data, std::size_t size, const std::string& name);

inline void check_image(ImageReader read, const std::uint8_t* data, std::size_t size) {
  reads_or_says_why(ErrorKind::input, [&] {
    const GreyImage image = read(data, size, "fuzz");
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    require(pixels > 0 && image.pixels.size() == pixels);
    require(image.alpha.empty() || image.alpha.size() == pixels);
  });
}

}  // namespace parloc::fuzz
