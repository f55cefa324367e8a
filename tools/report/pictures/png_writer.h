// 8-bit PNG images in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/report/pictures/pixel.h"

namespace parloc::tools {

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
