// PGM, plain (P2) and raw (P5), as defined by Netpbm's pgm(5).
#include <fmt/format.h>

#include <cstddef>
#include <string>

#include "common/error.h"
#include "common/map/map_limits.h"
#include "common/map/map_reader.h"

namespace parloc {
namespace {

bool is_space(std::uint8_t c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}
bool is_digit(std::uint8_t c) {
  return c >= '0' && c <= '9';
}

/// Walks over the bytes of a file and counts its lines.
class PgmBytes {
 public:
  PgmBytes(const std::uint8_t* data, std::size_t size, const std::string& name)
      : data_(data), size_(size), name_(name) {}

  std::size_t left() const { return size_ - position_; }
  const std::uint8_t* here() const { return data_ + position_; }
  std::uint8_t take() {
    const std::uint8_t c = data_[position_++];
    if (c == '\n') ++line_;
    return c;
  }
  [[noreturn]] void fail(const std::string& message) const { throw input_error(name_, line_, message); }
  [[noreturn]] void fail_file(const std::string& message) const { throw input_error(name_, 0, message); }

  /// White space, and comments from '#' to the end of the line.
  void skip_blanks() {
    while (left() > 0 && (is_space(*here()) || *here() == '#')) {
      if (take() == '#') skip_line();
    }
  }
  void skip_line() {
    while (left() > 0 && take() != '\n') {
    }
  }
  std::int32_t number(const char* what, std::int32_t low, std::int32_t high) {
    skip_blanks();
    if (left() == 0) fail(fmt::format("truncated: expected the {}, found the end of the file", what));
    std::int64_t value = 0;
    std::size_t digits = 0;
    for (; left() > 0 && is_digit(*here()); ++digits) {
      value = value * 10 + (take() - '0');
      if (value > high) fail(fmt::format("the {} must be {} to {}, got {} or more", what, low, high, value));
    }
    if (digits == 0 || (left() > 0 && !is_space(*here()) && *here() != '#')) {
      fail(fmt::format("expected the {} as a whole number, found the byte 0x{:02x}", what, *here()));
    }
    if (value < low) fail(fmt::format("the {} must be {} to {}, got {}", what, low, high, value));
    return static_cast<std::int32_t>(value);
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  const std::string& name_;
  std::size_t position_ = 0;
  std::size_t line_ = 1;
};

struct Raster {
  std::int32_t width, height, largest;
  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// Puts pixels into an image, which has 8 bits of each and, where these are not all, 16.
class PixelSink {
 public:
  PixelSink(GreyImage& image, const Raster& raster)
      : image_(image), largest_(static_cast<std::uint32_t>(raster.largest)), is_fine_(255 % largest_ != 0) {
    image_.pixels.reserve(raster.pixels());
    if (is_fine_) image_.colour_sums.reserve(raster.pixels());
  }

  void put(std::uint32_t value) {
    image_.pixels.push_back(scaled<std::uint8_t>(value));
    if (is_fine_) image_.colour_sums.push_back(3u * scaled<std::uint16_t>(value));
  }

 private:
  template <class Scaled>
  Scaled scaled(std::uint32_t value) const {
    return static_cast<Scaled>((value * std::uint32_t{Scaled(~Scaled{})} + largest_ / 2u) / largest_);
  }

  GreyImage& image_;
  std::uint32_t largest_;
  bool is_fine_;  ///< 8 bits do not hold every value: 0 to 255 is not a whole number of steps.
};

void read_raw(PgmBytes& bytes, const Raster& raster, GreyImage& image) {
  // One white space character ends the header; a comment right there counts as one, as in Netpbm.
  if (bytes.left() > 0 && bytes.take() == '#') bytes.skip_line();
  const std::size_t depth = raster.largest > 255 ? 2 : 1;
  const std::size_t expected = raster.pixels() * depth;
  const std::size_t found = bytes.left();
  if (found < expected) {
    bytes.fail_file(fmt::format("truncated: expected {} bytes of pixels ({} x {}, maxval {}), found {}",
                                expected, raster.width, raster.height, raster.largest, found));
  }
  PixelSink pixels(image, raster);
  const std::uint8_t* data = bytes.here();
  for (std::size_t k = 0; k < raster.pixels(); ++k) {
    const std::uint32_t value = depth == 1 ? data[k] : data[2 * k] * 256u + data[2 * k + 1];
    if (value > static_cast<std::uint32_t>(raster.largest)) {
      bytes.fail_file(
          fmt::format("pixel {} is {}: expected at most the maxval {}", k, value, raster.largest));
    }
    pixels.put(value);
  }
  for (std::size_t k = expected; k < found; ++k) {
    if (!is_space(data[k])) {
      bytes.fail_file(fmt::format("expected {} bytes of pixels ({} x {}, maxval {}), found {}", expected,
                                  raster.width, raster.height, raster.largest, found));
    }
  }
}

void read_plain(PgmBytes& bytes, const Raster& raster, GreyImage& image) {
  const std::size_t least = 2 * raster.pixels() - 1;  // one digit each, and something between them
  if (bytes.left() < least) {
    bytes.fail_file(fmt::format("truncated: expected at least {} bytes of pixels ({} x {} numbers), found {}",
                                least, raster.width, raster.height, bytes.left()));
  }
  PixelSink pixels(image, raster);
  for (std::size_t k = 0; k < raster.pixels(); ++k) {
    bytes.skip_blanks();
    if (bytes.left() == 0) {
      bytes.fail_file(fmt::format("truncated: expected {} pixels ({} x {}), found {}", raster.pixels(),
                                  raster.width, raster.height, k));
    }
    pixels.put(static_cast<std::uint32_t>(bytes.number("pixel", 0, raster.largest)));
  }
  bytes.skip_blanks();
  if (bytes.left() > 0) {
    bytes.fail(fmt::format("expected {} pixels ({} x {}), found more", raster.pixels(), raster.width,
                           raster.height));
  }
}

}  // namespace

GreyImage read_pgm(const std::uint8_t* data, std::size_t size, const std::string& name) {
  PgmBytes bytes(data, size, name);
  if (size < 2 || data[0] != 'P' || (data[1] != '2' && data[1] != '5')) {
    bytes.fail_file("expected a PGM image, which starts with P2 or P5");
  }
  const bool plain = data[1] == '2';
  bytes.take();
  bytes.take();
  if (bytes.left() > 0 && !is_space(*bytes.here()) && *bytes.here() != '#') {
    bytes.fail("expected white space after P2 or P5");
  }
  Raster raster{};
  raster.width = bytes.number("width", 1, kMaxMapSide);
  raster.height = bytes.number("height", 1, kMaxMapSide);
  raster.largest = bytes.number("maxval", 1, 65535);
  GreyImage image;
  image.width = raster.width;
  image.height = raster.height;
  plain ? read_plain(bytes, raster, image) : read_raw(bytes, raster, image);
  return image;
}

}  // namespace parloc
