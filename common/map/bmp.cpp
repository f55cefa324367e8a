// BMP without compression, of Windows (all its headers) and OS/2, as docs/maps.md says.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstddef>
#include <string>

#include "common/error.h"
#include "common/map/map_limits.h"
#include "common/map/map_reader.h"

namespace parloc {
namespace {

constexpr std::size_t kFileHeader = 14;  // "BM", size, two reserved numbers, where the pixels are
constexpr std::uint32_t kNoCompression = 0, kBitFields = 3, kAlphaBitFields = 6;

const char* compression_name(std::uint32_t compression) {
  switch (compression) {
    case 1:
      return "RLE8 compression";
    case 2:
      return "RLE4 compression";
    case 4:
      return "JPEG compression";
    case 5:
      return "PNG compression";
    default:
      return "an unknown compression";
  }
}

/// Little-endian numbers of a file, each asked for by its place.
class BmpBytes {
 public:
  BmpBytes(const std::uint8_t* data, std::size_t size, const std::string& name)
      : data_(data), size_(size), name_(name) {}

  std::size_t size() const { return size_; }
  const std::uint8_t* at(std::size_t place) const { return data_ + place; }
  /// That the bytes from `place` on are there.
  void expect(std::size_t place, std::size_t count, const char* what) const {
    if (place > size_ || count > size_ - place)
      fail(fmt::format("truncated: expected {} bytes of {} from byte {} on, found {}", count, what, place,
                       place > size_ ? 0 : size_ - place));
  }
  std::uint32_t number(std::size_t place, std::size_t bytes) const {
    expect(place, bytes, "the header");
    std::uint32_t value = 0;
    for (std::size_t k = bytes; k-- > 0;) value = value << 8 | data_[place + k];
    return value;
  }
  [[noreturn]] void fail(const std::string& message) const { throw input_error(name_, 0, message); }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  const std::string& name_;
};

/// What the headers say.
struct BmpLayout {
  std::size_t header;                                             // bytes of the second header
  std::int64_t width, height;                                     // height: positive
  bool top_down;                                                  // the first row in the file is the top one
  std::uint32_t bits;                                             // per pixel
  std::uint32_t compression;                                      // kNoCompression, or masks in the header
  std::size_t pixels_at;                                          // from the file's beginning
  std::uint32_t colours;                                          // of the palette, 0: none or 2^bits
  std::array<std::uint32_t, 4> masks{0xff0000, 0xff00, 0xff, 0};  // of 32 bits: red, green, blue, alpha

  std::size_t row_bytes() const {  // rows are filled up to whole 4 bytes
    return (static_cast<std::size_t>(width) * bits + 31) / 32 * 4;
  }
};

void check_size(const BmpBytes& bytes, const BmpLayout& layout) {
  if (layout.width < 1 || layout.width > kMaxMapSide || layout.height < 1 || layout.height > kMaxMapSide)
    bytes.fail(fmt::format("image of {} x {} pixels: expected sides from 1 to {}", layout.width,
                           layout.height, kMaxMapSide));
}

void check_kind(const BmpBytes& bytes, const BmpLayout& layout) {
  const bool masked = layout.compression == kBitFields || layout.compression == kAlphaBitFields;
  if (layout.compression != kNoCompression && !masked)
    bytes.fail(fmt::format("a BMP with {} is not supported: expected one without",
                           compression_name(layout.compression)));
  for (const std::uint32_t known : {1u, 4u, 8u, 24u, 32u})
    if (layout.bits == known && (!masked || known == 32u)) return;
  bytes.fail(fmt::format("a BMP of {} bits per pixel{} is not supported: expected 1, 4, 8, 24 or 32",
                         layout.bits, masked ? " with masks" : ""));
}

/// Masks are at the same place in every header that has them, and right behind the one of 40 bytes.
void read_masks(const BmpBytes& bytes, BmpLayout& layout) {
  const bool has_alpha = layout.header >= 56 || layout.compression == kAlphaBitFields;
  for (std::size_t c = 0; c < (has_alpha ? 4u : 3u); ++c)
    layout.masks[c] = bytes.number(kFileHeader + 40 + 4 * c, 4);
  for (std::size_t c = 0; c < 4; ++c) {
    const std::uint32_t mask = layout.masks[c];
    if (c == 3 && mask == 0) continue;
    if (mask == 0 || std::rotr(mask, std::countr_zero(mask)) != 0xff || std::countr_zero(mask) % 8 != 0)
      bytes.fail(
          fmt::format("the mask 0x{:08x} of a channel is not supported: expected one whole byte", mask));
  }
}

BmpLayout read_layout(const BmpBytes& bytes) {
  BmpLayout layout{};
  layout.header = bytes.number(kFileHeader, 4);
  layout.pixels_at = bytes.number(10, 4);
  if (layout.header == 12) {  // of OS/2 1
    layout.width = bytes.number(18, 2);
    layout.height = bytes.number(20, 2);
    layout.bits = bytes.number(24, 2);
  } else {
    if (layout.header < 40 || layout.header > 4096)
      bytes.fail(fmt::format("expected a BMP header of 12 or at least 40 bytes, found {}", layout.header));
    layout.width = static_cast<std::int32_t>(bytes.number(18, 4));
    layout.height = static_cast<std::int32_t>(bytes.number(22, 4));
    layout.bits = bytes.number(28, 2);
    layout.compression = bytes.number(30, 4);
    layout.colours = bytes.number(46, 4);
  }
  layout.top_down = layout.height < 0;
  if (layout.top_down) layout.height = -layout.height;
  check_size(bytes, layout);
  check_kind(bytes, layout);
  if (layout.compression != kNoCompression) {
    read_masks(bytes, layout);
  } else if (layout.bits == 32) {
    layout.masks[3] = 0xff000000;  // as GraphicsMagick takes it, and so nav2
  }
  return layout;
}

/// Sums of red, green and blue for each index; black beyond what the file has.
std::array<std::uint32_t, 256> read_palette(const BmpBytes& bytes, const BmpLayout& layout) {
  const std::uint32_t most = std::uint32_t{1} << layout.bits;
  if (layout.colours > most)
    bytes.fail(fmt::format("expected at most {} colours with {} bits per pixel, found {}", most, layout.bits,
                           layout.colours));
  const std::size_t count = layout.colours == 0 ? most : layout.colours;
  const std::size_t each = layout.header == 12 ? 3 : 4;
  const std::size_t place = kFileHeader + layout.header;
  bytes.expect(place, count * each, "the palette");
  std::array<std::uint32_t, 256> sums{};
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint8_t* colour = bytes.at(place + k * each);
    sums[k] = std::uint32_t{colour[0]} + colour[1] + colour[2];
  }
  return sums;
}

void put(GreyImage& image, std::size_t k, std::uint32_t sum) {
  image.pixels[k] = static_cast<std::uint8_t>((sum + 1) / 3);
  image.colour_sums[k] = 257 * sum;
}

void put_indexed_row(const std::uint8_t* row, std::size_t first, const BmpLayout& layout,
                     const std::array<std::uint32_t, 256>& palette, GreyImage& image) {
  const std::uint32_t per_byte = 8 / layout.bits, mask = (1u << layout.bits) - 1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(image.width); ++i) {
    const auto shift = static_cast<std::uint32_t>(8 - layout.bits * (i % per_byte + 1));  // left pixel first
    put(image, first + i, palette[row[i / per_byte] >> shift & mask]);
  }
}

void put_colour_row(const std::uint8_t* row, std::size_t first, const BmpLayout& layout, GreyImage& image) {
  const std::size_t bytes_each = layout.bits / 8;
  const auto channel = [&](const std::uint8_t* pixel, std::uint32_t mask) {
    return pixel[std::countr_zero(mask) / 8];
  };
  for (std::size_t i = 0; i < static_cast<std::size_t>(image.width); ++i) {
    const std::uint8_t* pixel = row + i * bytes_each;
    std::uint32_t sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += channel(pixel, layout.masks[c]);
    put(image, first + i, sum);
    if (!image.alpha.empty()) image.alpha[first + i] = channel(pixel, layout.masks[3]);
  }
}

}  // namespace

GreyImage read_bmp(const std::uint8_t* data, std::size_t size, const std::string& name) {
  const BmpBytes bytes(data, size, name);
  if (size < 2 || data[0] != 'B' || data[1] != 'M') bytes.fail("expected a BMP image, which starts with BM");
  const BmpLayout layout = read_layout(bytes);
  const auto width = static_cast<std::size_t>(layout.width), height = static_cast<std::size_t>(layout.height);
  bytes.expect(layout.pixels_at, layout.row_bytes() * height, "pixels");  // before memory is asked for
  const std::array<std::uint32_t, 256> palette =
      layout.bits <= 8 ? read_palette(bytes, layout) : std::array<std::uint32_t, 256>{};
  GreyImage image;
  image.width = static_cast<std::int32_t>(layout.width);
  image.height = static_cast<std::int32_t>(layout.height);
  image.pixels.resize(width * height);
  image.colour_sums.resize(width * height);
  if (layout.masks[3] != 0) image.alpha.resize(width * height);
  for (std::size_t r = 0; r < height; ++r) {
    const std::uint8_t* row = bytes.at(layout.pixels_at + r * layout.row_bytes());
    const std::size_t first = (layout.top_down ? r : height - 1 - r) * width;
    if (layout.bits <= 8) {
      put_indexed_row(row, first, layout, palette, image);
    } else {
      put_colour_row(row, first, layout, image);
    }
  }
  return image;
}

}  // namespace parloc
