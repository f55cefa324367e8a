// 8-bit PNG images in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace parloc::tools {

struct Rgba {
  std::uint8_t red = 0, green = 0, blue = 0, alpha = 255;
};

enum class PngEffort { small, fast };  ///< What counts more: the size of the file, or the time.

/// `pixels` holds width * height * 3 bytes (red, green, blue), row 0 at the top. The bytes of a PNG file.
/// Throws Error{internal} if the sizes do not fit or libpng fails.
std::string encode_png_rgb(std::int32_t width, std::int32_t height, const std::vector<std::uint8_t>& pixels,
                           PngEffort effort = PngEffort::small);

/// `pixels` holds width * height indices into `palette` (1 to 256 colours). Throws Error{internal} likewise.
std::string encode_png_palette(std::int32_t width, std::int32_t height,
                               const std::vector<std::uint8_t>& pixels, const std::vector<Rgba>& palette);

/// "data:image/png;base64,..." for an image inside a web page.
std::string png_data_uri(const std::string& png);

}  // namespace parloc::tools
