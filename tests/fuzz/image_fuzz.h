// What every image reader must hold: any bytes are an image with all of its pixels, or an Error{input} of one
// line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/error.h"
#include "common/map/map_reader.h"

namespace parloc::fuzz {

using ImageReader = GreyImage (*)(const std::uint8_t* data, std::size_t size, const std::string& name);

inline void check_image(ImageReader read, const std::uint8_t* data, std::size_t size) {
  try {
    const GreyImage image = read(data, size, "fuzz");
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (pixels == 0 || image.pixels.size() != pixels) std::abort();
    if (!image.alpha.empty() && image.alpha.size() != pixels) std::abort();
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::input) std::abort();
    if (std::string(e.what()).find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace parloc::fuzz
