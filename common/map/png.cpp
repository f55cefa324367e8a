// PNG through libpng. libpng reports an error by a longjmp: `attempt` is the only place that sets the target,
// and between the two lie only frames without destructors.
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/map/map_limits.h"
#include "common/map/map_reader.h"

namespace parloc {
namespace {

/// libpng's state, the bytes that it reads, and its last complaint.
struct Decoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  const std::uint8_t* next = nullptr;
  std::size_t left = 0;
  char message[160] = "not enough memory";

  Decoder() = default;
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  auto* decoder = static_cast<Decoder*>(png_get_error_ptr(png));
  std::snprintf(decoder->message, sizeof decoder->message, "%s", text);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}  // about ancillary chunks, none of which is used

void on_read(png_structp png, png_bytep out, std::size_t count) {
  auto* decoder = static_cast<Decoder*>(png_get_io_ptr(png));
  if (count > decoder->left) {
    char text[120];
    std::snprintf(text, sizeof text, "truncated: expected %zu more bytes, found %zu", count, decoder->left);
    png_error(png, text);
  }
  std::memcpy(out, decoder->next, count);
  decoder->next += count;
  decoder->left -= count;
}

/// Runs libpng calls; false if one of them failed (decoder.message says why).
template <class Calls>
bool attempt(Decoder& decoder, const Calls& calls) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  calls(decoder.png, decoder.info);
  return true;
}

/// What the image is once libpng has expanded it to 8 or 16 bits a channel.
struct PngLayout {
  png_uint_32 width, height;
  std::size_t channels;  // grey, grey + alpha, RGB or RGBA
  std::size_t depth;     // bytes of a channel, 1 or 2
  std::size_t pixels() const { return std::size_t{width} * height; }
  bool has_alpha() const { return channels == 2 || channels == 4; }
};

bool open(Decoder& decoder, const std::uint8_t* data, std::size_t size) {
  decoder.next = data;
  decoder.left = size;
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, on_error, on_warning);
  if (decoder.png == nullptr) return false;
  decoder.info = png_create_info_struct(decoder.png);
  if (decoder.info == nullptr) return false;
  return attempt(decoder, [&](png_structp png, png_infop info) {
    png_set_read_fn(png, &decoder, on_read);
    png_set_user_limits(png, PNG_UINT_31_MAX,
                        PNG_UINT_31_MAX);  // check_size has the limits, with a clear message
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);  // no text, profiles, ...
    png_read_info(png, info);
  });
}

/// Refuses a size that no map has, and one that the file cannot hold: deflate shrinks at most 1032-fold, so a
/// small file cannot make us allocate a large image.
void check_size(const Decoder& decoder, std::size_t size, const std::string& name) {
  const std::size_t width = png_get_image_width(decoder.png, decoder.info);
  const std::size_t height = png_get_image_height(decoder.png, decoder.info);
  const std::size_t longest = static_cast<std::size_t>(kMaxMapSide);
  if (width > longest || height > longest) {
    throw input_error(
        name, 0, fmt::format("image of {} x {} pixels: expected sides from 1 to {}", width, height, longest));
  }
  const std::size_t least = height * (1 + png_get_rowbytes(decoder.png, decoder.info)) / 1032;
  if (size < least) {
    throw input_error(name, 0,
                      fmt::format("truncated PNG: expected at least {} bytes for {} x {} pixels, found {}",
                                  least, width, height, size));
  }
}

/// Any depth and colour type to 8 or 16 bits a channel; a palette to RGB, a transparent colour to alpha.
bool expand_to_bytes(Decoder& decoder, PngLayout& layout) {
  return attempt(decoder, [&](png_structp png, png_infop info) {
    png_set_expand(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    layout = {png_get_image_width(png, info), png_get_image_height(png, info), png_get_channels(png, info),
              png_get_bit_depth(png, info) == 16 ? std::size_t{2} : 1};
  });
}

/// A channel's value with 16 bits.
std::uint16_t value_16(const std::uint8_t* channel, std::size_t depth) {
  return static_cast<std::uint16_t>(depth == 2 ? channel[0] * 256 + channel[1] : channel[0] * 257);
}

/// ... and with 8, which of 16 are the nearest.
std::uint8_t value_8(std::uint16_t value) {
  return static_cast<std::uint8_t>((value * 255u + 32895u) >> 16);
}

/// Grey is the mean of the colours: exactly, and of what each is with 8 bits.
void put_pixels(const std::vector<std::uint8_t>& bytes, const PngLayout& layout, GreyImage& image) {
  const bool has_colours = layout.channels >= 3;
  const bool is_fine = has_colours || layout.depth == 2;
  image.pixels.resize(layout.pixels());
  if (is_fine) image.colour_sums.resize(layout.pixels());
  if (layout.has_alpha()) image.alpha.resize(layout.pixels());
  if (layout.has_alpha() && layout.depth == 2) image.alpha_16.resize(layout.pixels());
  for (std::size_t k = 0; k < layout.pixels(); ++k) {
    const std::uint8_t* pixel = bytes.data() + k * layout.channels * layout.depth;
    const auto channel = [&](std::size_t c) { return value_16(pixel + c * layout.depth, layout.depth); };
    const std::uint16_t red = channel(0), green = has_colours ? channel(1) : red,
                        blue = has_colours ? channel(2) : red;
    const int sum_8 = value_8(red) + value_8(green) + value_8(blue);
    image.pixels[k] = static_cast<std::uint8_t>((sum_8 + 1) / 3);
    if (is_fine) image.colour_sums[k] = std::uint32_t{red} + green + blue;
    if (!layout.has_alpha()) continue;
    const std::uint16_t alpha = channel(layout.channels - 1);
    image.alpha[k] = value_8(alpha);
    if (!image.alpha_16.empty()) image.alpha_16[k] = alpha;
  }
}

/// All rows, one after the other, interlaced or not.
bool read_rows(Decoder& decoder, const PngLayout& layout, std::vector<std::uint8_t>& bytes) {
  const std::size_t row_bytes = png_get_rowbytes(decoder.png, decoder.info);
  bytes.resize(row_bytes * layout.height);
  std::vector<png_bytep> rows(layout.height);
  for (std::size_t r = 0; r < rows.size(); ++r) rows[r] = bytes.data() + r * row_bytes;
  return attempt(decoder, [&](png_structp png, png_infop) {
    png_read_image(png, rows.data());
    png_read_end(png, nullptr);
  });
}

}  // namespace

GreyImage read_png(const std::uint8_t* data, std::size_t size, const std::string& name) {
  Decoder decoder;
  const auto corrupt = [&] { return input_error(name, 0, std::string("corrupt PNG: ") + decoder.message); };
  if (!open(decoder, data, size)) throw corrupt();
  check_size(decoder, size, name);
  PngLayout layout{};
  if (!expand_to_bytes(decoder, layout)) throw corrupt();
  std::vector<std::uint8_t> bytes;
  if (!read_rows(decoder, layout, bytes)) throw corrupt();
  GreyImage image{
      static_cast<std::int32_t>(layout.width), static_cast<std::int32_t>(layout.height), {}, {}, {}, {}};
  if (layout.channels == 1 && layout.depth == 1) {
    image.pixels = std::move(bytes);
  } else {
    put_pixels(bytes, layout, image);
  }
  return image;
}

}  // namespace parloc
