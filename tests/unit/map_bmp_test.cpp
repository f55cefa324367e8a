// BMP images, good and broken.
#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "common/map/map_reader.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

using Bytes = std::vector<std::uint8_t>;

GreyImage bmp(const Bytes& bytes) {
  return read_bmp(bytes.data(), bytes.size(), "m.bmp");
}

void put(Bytes& bytes, std::size_t at, std::uint32_t value, std::size_t count = 4) {
  for (std::size_t k = 0; k < count; ++k) bytes[at + k] = static_cast<std::uint8_t>(value >> (8 * k));
}

constexpr std::uint32_t kWidth = 5, kHeight = 3;  // no row ends at whole 4 bytes

/// What a BMP is made of.
struct Shape {
  std::uint32_t bits = 8;
  std::uint32_t header = 40;
  bool top_down = false;
  std::uint32_t compression = 0;
  std::uint32_t colours = 0;  ///< Of the palette; 0: all.

  std::uint32_t palette_size() const { return bits > 8 ? 0 : colours > 0 ? colours : 1u << bits; }
  std::uint32_t colour_bytes() const { return header == 12 ? 3 : 4; }
  std::uint32_t masks() const { return compression == 3 && header == 40 ? 12 : 0; }
  std::uint32_t pixels_at() const { return 14 + header + masks() + palette_size() * colour_bytes(); }
  std::uint32_t row_bytes() const { return (kWidth * bits + 31) / 32 * 4; }
};

std::uint32_t index_of(const Shape& shape, std::uint32_t x, std::uint32_t y) {
  return (x * 7 + y * 11 + 3) % shape.palette_size();
}
/// Blue, green, red, alpha of a pixel, or of a palette's entry with y = 0.
std::uint32_t channel(std::uint32_t x, std::uint32_t y, std::uint32_t c) {
  return (x * 53 + y * 101 + c * 37 + 19) & 255;
}

Bytes encode(const Shape& shape) {
  Bytes bytes(shape.pixels_at() + shape.row_bytes() * kHeight);
  bytes[0] = 'B', bytes[1] = 'M';
  put(bytes, 2, static_cast<std::uint32_t>(bytes.size()));
  put(bytes, 10, shape.pixels_at());
  put(bytes, 14, shape.header);
  const std::size_t each = shape.header == 12 ? 2 : 4;
  put(bytes, 18, kWidth, each);
  put(bytes, 18 + each, shape.top_down ? 0u - kHeight : kHeight, each);
  put(bytes, 18 + 2 * each, 1, 2);
  put(bytes, 20 + 2 * each, shape.bits, 2);
  if (shape.header > 12) put(bytes, 30, shape.compression), put(bytes, 46, shape.colours);
  if (shape.compression == 3) {
    put(bytes, 54, 0xff), put(bytes, 58, 0xff00), put(bytes, 62, 0xff0000);  // red is the first byte
    if (shape.header >= 56) put(bytes, 66, 0xff000000);
  }
  for (std::uint32_t k = 0; k < shape.palette_size(); ++k)
    for (std::uint32_t c = 0; c < 3; ++c)
      bytes[14 + shape.header + k * shape.colour_bytes() + c] = static_cast<std::uint8_t>(channel(k, 0, c));
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    const std::uint32_t row = shape.top_down ? y : kHeight - 1 - y;
    std::uint8_t* to = bytes.data() + shape.pixels_at() + row * shape.row_bytes();
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      if (shape.bits > 8) {
        for (std::uint32_t c = 0; c < shape.bits / 8; ++c)
          to[x * shape.bits / 8 + c] = static_cast<std::uint8_t>(channel(x, y, c));
      } else {
        to[x * shape.bits / 8] |=
            static_cast<std::uint8_t>(index_of(shape, x, y) << (8 - shape.bits - x * shape.bits % 8));
      }
    }
  }
  return bytes;
}

TEST(Bmp, EveryShapeIsRead) {
  const std::vector<Shape> shapes{{1},
                                  {4},
                                  {8},
                                  {8, 40, false, 0, 200},
                                  {24},
                                  {32},
                                  {8, 12},
                                  {24, 12},
                                  {8, 108, true},
                                  {24, 124, true},
                                  {4, 64, true},
                                  {32, 40, true, 3},
                                  {32, 56, false, 3},
                                  {32, 124, false, 3}};
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(std::to_string(shape.bits) + " bits, header " + std::to_string(shape.header));
    const GreyImage image = bmp(encode(shape));
    ASSERT_EQ(image.width, 5);
    ASSERT_EQ(image.height, 3);
    const bool has_alpha = shape.bits == 32 && (shape.compression == 0 || shape.header >= 56);
    ASSERT_EQ(image.alpha.size(), has_alpha ? 15u : 0u);
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        const std::uint32_t k = y * kWidth + x;
        const std::uint32_t place = shape.bits > 8 ? x : index_of(shape, x, y), row = shape.bits > 8 ? y : 0;
        const std::uint32_t sum = channel(place, row, 0) + channel(place, row, 1) + channel(place, row, 2);
        EXPECT_EQ(image.colour_sums[k], 257 * sum) << x << ", " << y;
        EXPECT_EQ(image.pixels[k], (sum + 1) / 3) << x << ", " << y;
        if (has_alpha) {
          EXPECT_EQ(image.alpha[k], channel(x, y, 3)) << x << ", " << y;
        }
      }
    }
  }
}

TEST(Bmp, WhatFollowsThePixelsIsNotRead) {
  Bytes bytes = encode({8});
  bytes.resize(bytes.size() + 100, 'x');  // a colour profile, say
  EXPECT_EQ(bmp(bytes).pixels, bmp(encode({8})).pixels);
}

TEST(Bmp, EveryTruncationIsAnError) {
  for (const Shape& shape : {Shape{1}, Shape{24, 124, true}, Shape{32, 40, false, 3}}) {
    const Bytes whole = encode(shape);
    for (std::size_t size = 2; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_EQ(error_of([&] { bmp(cut); }).rfind("m.bmp: truncated: expected ", 0), 0u) << size;
    }
  }
}

TEST(Bmp, EachMistakeHasOneClearLine) {
  const auto message = [](Bytes bytes, const std::function<void(Bytes&)>& change) {
    change(bytes);
    return error_of([&] { bmp(bytes); });
  };
  const auto changed = [&](std::size_t at, std::uint32_t value, std::size_t count = 4) {
    return message(encode({8}), [&](Bytes& bytes) { put(bytes, at, value, count); });
  };
  EXPECT_EQ(error_of([] { bmp({'P', '5'}); }), "m.bmp: expected a BMP image, which starts with BM");
  EXPECT_EQ(changed(14, 16), "m.bmp: expected a BMP header of 12 or at least 40 bytes, found 16");
  EXPECT_EQ(changed(14, 0xffffffff),
            "m.bmp: expected a BMP header of 12 or at least 40 bytes, found 4294967295");
  EXPECT_EQ(changed(18, 0), "m.bmp: image of 0 x 3 pixels: expected sides from 1 to 32767");
  EXPECT_EQ(changed(18, 0xffffffff), "m.bmp: image of -1 x 3 pixels: expected sides from 1 to 32767");
  EXPECT_EQ(changed(22, 0x80000000), "m.bmp: image of 5 x 2147483648 pixels: expected sides from 1 to 32767");
  EXPECT_EQ(changed(10, 0xffffffff),
            "m.bmp: truncated: expected 24 bytes of pixels from byte 4294967295 on, found 0");
  EXPECT_EQ(changed(46, 0xffffffff),
            "m.bmp: expected at most 256 colours with 8 bits per pixel, found 4294967295");
  EXPECT_EQ(changed(28, 16, 2),
            "m.bmp: a BMP of 16 bits per pixel is not supported: expected 1, 4, 8, 24 or 32");
  EXPECT_EQ(changed(30, 1), "m.bmp: a BMP with RLE8 compression is not supported: expected one without");
  EXPECT_EQ(changed(30, 2), "m.bmp: a BMP with RLE4 compression is not supported: expected one without");
  EXPECT_EQ(changed(30, 5), "m.bmp: a BMP with PNG compression is not supported: expected one without");
  EXPECT_EQ(changed(30, 77),
            "m.bmp: a BMP with an unknown compression is not supported: expected one without");
  EXPECT_EQ(message(encode({32, 40, false, 3}), [](Bytes& bytes) { put(bytes, 54, 0x7c00); }),
            "m.bmp: the mask 0x00007c00 of a channel is not supported: expected one whole byte");
  // Sides that the file is too short for cost nothing.
  EXPECT_EQ(message(encode({32}), [](Bytes& bytes) { put(bytes, 18, 32767), put(bytes, 22, 32767); }),
            "m.bmp: truncated: expected 4294705156 bytes of pixels from byte 54 on, found 60");
}

}  // namespace
}  // namespace parloc
