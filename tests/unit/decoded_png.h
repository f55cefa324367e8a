// A PNG file as pixels, by libpng and not by parloc's own reader.
#pragma once

#include <png.h>

#include <cstdint>
#include <string>
#include <vector>

namespace parloc {

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

inline Picture decode(const std::string& png) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr) == 0) return {};
  return picture;
}

}  // namespace parloc
