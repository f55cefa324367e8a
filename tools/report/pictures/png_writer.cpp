#include "tools/report/pictures/png_writer.h"

#include <png.h>

#include <algorithm>
#include <cstddef>

#include "common/error.h"

namespace parloc::tools {
namespace {

/// Everything but the pixels. libpng's simplified interface, because it reports errors without longjmp.
png_image describe(std::int32_t width, std::int32_t height, std::size_t bytes, std::size_t bytes_per_pixel) {
  const bool valid = width > 0 && height > 0;
  const std::size_t expected =
      valid ? static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * bytes_per_pixel : 0;
  if (!valid || bytes != expected) {
    throw Error(ErrorKind::internal, "png writer: " + std::to_string(bytes) + " bytes for an image of " +
                                         std::to_string(width) + " x " + std::to_string(height));
  }
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  return image;
}

std::string encode(png_image& image, const void* pixels, const void* colormap) {
  std::string png(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');  // an upper bound, so one pass is enough
  png_alloc_size_t size = png.size();
  if (png_image_write_to_memory(&image, png.data(), &size, 0, pixels, 0, colormap) == 0) {
    const std::string message = image.message;
    png_image_free(&image);
    throw Error(ErrorKind::internal, "png writer: " + message);
  }
  png.resize(size);
  return png;
}

}  // namespace

std::string encode_png_rgb(std::int32_t width, std::int32_t height, const std::vector<std::uint8_t>& pixels,
                           PngEffort effort) {
  png_image image = describe(width, height, pixels.size(), 3);
  if (effort == PngEffort::fast) image.flags |= PNG_IMAGE_FLAG_FAST;
  image.format = PNG_FORMAT_RGB;
  return encode(image, pixels.data(), nullptr);
}

std::string encode_png_palette(std::int32_t width, std::int32_t height,
                               const std::vector<std::uint8_t>& pixels, const std::vector<Rgba>& palette) {
  png_image image = describe(width, height, pixels.size(), 1);
  const bool fits =
      !palette.empty() && palette.size() <= 256 &&
      std::all_of(pixels.begin(), pixels.end(), [&](std::uint8_t p) { return p < palette.size(); });
  if (!fits) throw Error(ErrorKind::internal, "png writer: a pixel outside the palette");
  image.format = PNG_FORMAT_RGBA_COLORMAP;
  image.colormap_entries = static_cast<png_uint_32>(palette.size());
  std::vector<std::uint8_t> colormap;
  for (const Rgba& c : palette) colormap.insert(colormap.end(), {c.red, c.green, c.blue, c.alpha});
  return encode(image, pixels.data(), colormap.data());
}

std::string png_data_uri(const std::string& png) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = "data:image/png;base64,";
  uri.reserve(uri.size() + (png.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < png.size(); at += 3) {
    const std::size_t count = std::min<std::size_t>(3, png.size() - at);
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      triple = triple << 8 | (k < count ? static_cast<std::uint8_t>(png[at + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) uri += k <= count ? digits[triple >> (18 - 6 * k) & 63U] : '=';
  }
  return uri;
}

}  // namespace parloc::tools
