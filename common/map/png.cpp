// PNG through libpng. libpng reports an error by a longjmp: `attempt` is the only place that sets the target,
// and between the two lie only frames without destructors.
#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string>

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

/// What the image is once libpng has expanded it to 8 bits a channel.
struct Layout {
  png_uint_32 width, height;
  std::size_t channels;  // grey, grey + alpha, RGB or RGBA
  bool interlaced;
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

/// Any depth and colour type to 8 bits a channel; a palette to RGB, a transparent colour to alpha.
bool expand_to_8_bits(Decoder& decoder, Layout& layout) {
  return attempt(decoder, [&](png_structp png, png_infop info) {
    png_set_expand(png);
    png_set_scale_16(png);
    png_read_update_info(png, info);
    layout = {png_get_image_width(png, info), png_get_image_height(png, info), png_get_channels(png, info),
              png_get_interlace_type(png, info) != PNG_INTERLACE_NONE};
  });
}

std::uint8_t mean_colour(const std::uint8_t* pixel, std::size_t channels) {
  return channels < 3 ? pixel[0] : static_cast<std::uint8_t>((pixel[0] + pixel[1] + pixel[2] + 1) / 3);
}

/// Reads `columns` pixels as one row of libpng's output; they lie `step` apart in the image, from pixel `at`
/// on.
bool read_row(Decoder& decoder, const Layout& layout, std::vector<std::uint8_t>& row, std::size_t at,
              std::size_t columns, std::size_t step, GreyImage& image) {
  if (!attempt(decoder, [&](png_structp png, png_infop) { png_read_row(png, row.data(), nullptr); }))
    return false;
  for (std::size_t k = 0; k < columns; ++k) {
    const std::uint8_t* pixel = row.data() + k * layout.channels;
    image.pixels[at + k * step] = mean_colour(pixel, layout.channels);
    if (layout.has_alpha()) image.alpha[at + k * step] = pixel[layout.channels - 1];
  }
  return true;
}

/// An interlaced image comes as seven smaller ones (Adam7), each with rows and columns of its own.
bool read_pixels(Decoder& decoder, const Layout& layout, GreyImage& image) {
  std::vector<std::uint8_t> row(png_get_rowbytes(decoder.png, decoder.info));
  const int passes = layout.interlaced ? PNG_INTERLACE_ADAM7_PASSES : 1;
  for (int pass = 0; pass < passes; ++pass) {
    const png_uint_32 rows = layout.interlaced ? PNG_PASS_ROWS(layout.height, pass) : layout.height;
    const png_uint_32 columns = layout.interlaced ? PNG_PASS_COLS(layout.width, pass) : layout.width;
    const std::size_t first = layout.interlaced ? PNG_PASS_START_COL(pass) : 0;
    const std::size_t step = layout.interlaced ? PNG_PASS_COL_OFFSET(pass) : 1;
    for (png_uint_32 r = 0; columns > 0 && r < rows; ++r) {
      const std::size_t image_row = layout.interlaced ? PNG_ROW_FROM_PASS_ROW(r, pass) : r;
      if (!read_row(decoder, layout, row, image_row * layout.width + first, columns, step, image))
        return false;
    }
  }
  return attempt(decoder, [](png_structp png, png_infop) { png_read_end(png, nullptr); });
}

}  // namespace

GreyImage read_png(const std::uint8_t* data, std::size_t size, const std::string& name) {
  Decoder decoder;
  const auto corrupt = [&] { return input_error(name, 0, std::string("corrupt PNG: ") + decoder.message); };
  if (!open(decoder, data, size)) throw corrupt();
  check_size(decoder, size, name);
  Layout layout{};
  if (!expand_to_8_bits(decoder, layout)) throw corrupt();
  GreyImage image;
  image.width = static_cast<std::int32_t>(layout.width);
  image.height = static_cast<std::int32_t>(layout.height);
  const std::size_t pixels = static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height);
  image.pixels.resize(pixels);
  if (layout.has_alpha()) image.alpha.resize(pixels);
  if (!read_pixels(decoder, layout, image)) throw corrupt();
  return image;
}

}  // namespace parloc
