// PGM and PNG images, good and broken. Those of BMP are in map_bmp_test.cpp.
#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include <utility>

#include "common/map/map_reader.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

using Bytes = std::vector<std::uint8_t>;

const std::uint8_t* bytes_of(const std::string& text) {
  return reinterpret_cast<const std::uint8_t*>(text.data());
}
GreyImage pgm(const std::string& text) {
  return read_pgm(bytes_of(text), text.size(), "m.pgm");
}
GreyImage png(const Bytes& bytes) {
  return read_png(bytes.data(), bytes.size(), "m.png");
}
std::string message_for(const Bytes& broken_png) {
  return error_of([&] { png(broken_png); });
}

// ---- PGM ----------------------------------------------------------------------------------------

TEST(Pgm, RawWithComments) {
  const GreyImage image = pgm("P5\n# CREATOR: someone 0.05 m/pix\n3#width\n 2\t255\n\x01\x02\x03#\x0a\xff");
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(image.pixels, (Bytes{1, 2, 3, '#', '\n', 255}));  // no comments among raw pixels
  EXPECT_TRUE(image.alpha.empty());
}

TEST(Pgm, PlainWithComments) {
  const GreyImage image = pgm("P2 # plain\n2 2 255\n0 1 # first row\n254\t255");
  EXPECT_EQ(image.pixels, (Bytes{0, 1, 254, 255}));
}

TEST(Pgm, AnyMaxvalIsScaledToEightBits) {
  EXPECT_EQ(pgm("P2 4 1 100 0 50 99 100").pixels, (Bytes{0, 128, 252, 255}));
  EXPECT_EQ(pgm("P2 2 1 1 0 1").pixels, (Bytes{0, 255}));
  EXPECT_EQ(pgm("P2 3 1 65535 128 129 65535").pixels, (Bytes{0, 1, 255}));  // 128 / 257 = 0.498
  const std::string raw =
      std::string("P5 2 1 65535\n") + '\x80' + '\x80' + '\xff' + '\xff';  // high byte first
  EXPECT_EQ(pgm(raw).pixels, (Bytes{128, 255}));
}

TEST(Pgm, WhiteSpaceMayFollowThePixels) {
  EXPECT_EQ(pgm("P5 1 1 255\na\n").pixels, (Bytes{'a'}));
  EXPECT_EQ(pgm("P2 1 1 255 7 \n# end\n").pixels, (Bytes{7}));
}

TEST(Pgm, EachMistakeHasOneClearLine) {
  const std::vector<std::pair<std::string, std::string>> mistakes{
      {"", "m.pgm: expected a PGM image, which starts with P2 or P5"},
      {"P6 1 1 255\nabc", "m.pgm: expected a PGM image, which starts with P2 or P5"},
      {"P51 1 255\na", "m.pgm:1: expected white space after P2 or P5"},
      {"P5", "m.pgm:1: truncated: expected the width, found the end of the file"},
      {"P5\n#\n\n12", "m.pgm:4: truncated: expected the height, found the end of the file"},
      {"P5\n12x", "m.pgm:2: expected the width as a whole number, found the byte 0x78"},
      {"P5\n-1 1 255\n", "m.pgm:2: expected the width as a whole number, found the byte 0x2d"},
      {"P5\n0 1 255\n", "m.pgm:2: the width must be 1 to 32767, got 0"},
      {"P5\n1 60000 255\n", "m.pgm:2: the height must be 1 to 32767, got 60000 or more"},
      {"P5\n99999999999999999999 1 255\n", "m.pgm:2: the width must be 1 to 32767, got 99999 or more"},
      {"P5 1 1 65536\n", "m.pgm:1: the maxval must be 1 to 65535, got 65536 or more"},
      {"P5 1 1 0\n", "m.pgm:1: the maxval must be 1 to 65535, got 0"},
      {"P5 3 2 255\nabcde", "m.pgm: truncated: expected 6 bytes of pixels (3 x 2, maxval 255), found 5"},
      {"P5 3 2 256\nabcde", "m.pgm: truncated: expected 12 bytes of pixels (3 x 2, maxval 256), found 5"},
      {"P5 30000 30000 255\n",
       "m.pgm: truncated: expected 900000000 bytes of pixels (30000 x 30000, maxval 255), found 0"},
      {"P5 2 1 255\nabc", "m.pgm: expected 2 bytes of pixels (2 x 1, maxval 255), found 3"},
      {"P5 2 1 10\n\x01\x0b", "m.pgm: pixel 1 is 11: expected at most the maxval 10"},
      {"P2 30000 30000 255\n1 2 3",
       "m.pgm: truncated: expected at least 1799999999 bytes of pixels (30000 x 30000 numbers), found 6"},
      {"P2 2 2 255\n10 20   30", "m.pgm: truncated: expected 4 pixels (2 x 2), found 3"},
      {"P2 2 1 255\n1\n2 3", "m.pgm:3: expected 2 pixels (2 x 1), found more"},
      {"P2 2 1 9\n1\n10", "m.pgm:3: the pixel must be 0 to 9, got 10 or more"},
      {"P2 2 1 9\n1\n?", "m.pgm:3: expected the pixel as a whole number, found the byte 0x3f"},
  };
  for (const auto& [text, message] : mistakes) EXPECT_EQ(error_of([&t = text] { pgm(t); }), message) << text;
}

// ---- PNG ----------------------------------------------------------------------------------------

void append(png_structp png, png_bytep data, std::size_t count) {
  auto* out = static_cast<Bytes*>(png_get_io_ptr(png));
  out->insert(out->end(), data, data + count);
}

struct PngShape {
  int colour_type;
  int depth;
  bool interlaced;
  bool has_alpha() const { return (colour_type & PNG_COLOR_MASK_ALPHA) != 0; }
  int channels() const {
    const bool rgb = (colour_type & ~PNG_COLOR_MASK_ALPHA) == PNG_COLOR_TYPE_RGB;
    return (rgb ? 3 : 1) + (has_alpha() ? 1 : 0);
  }
};

constexpr int kWidth = 13, kHeight = 11;  // all seven passes of an interlaced image have pixels, none is full

/// The sample written for a pixel and channel: every value of the depth, differently in each channel.
int sample(const PngShape& shape, int x, int y, int c) {
  const int top = (1 << shape.depth) - 1;
  return (x * 7919 + y * 104729 + c * 5147 + x * y * 31) & top;
}
/// The palette of an indexed image, and the alpha of its first half.
int palette(int index, int c) {
  return (index * (17 + 20 * c) + 40 * c) & 255;
}

/// `transparent`: a tRNS chunk as well (a grey or RGB value, or the alpha of half of the palette).
Bytes encode(const PngShape& shape, bool transparent = false) {
  Bytes out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &out, append, nullptr);
  png_set_IHDR(png, info, kWidth, kHeight, shape.depth, shape.colour_type,
               shape.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_gAMA(png, info, 1.0);  // must not change a value
  const int entries = 1 << (shape.depth < 8 ? shape.depth : 8);
  std::vector<png_color> colours;
  Bytes alpha;
  if (shape.colour_type == PNG_COLOR_TYPE_PALETTE) {
    for (int k = 0; k < entries; ++k) {
      const auto byte = [k](int c) { return static_cast<png_byte>(palette(k, c)); };
      colours.push_back({byte(0), byte(1), byte(2)});
      if (k < entries / 2) alpha.push_back(static_cast<png_byte>(k));
    }
    png_set_PLTE(png, info, colours.data(), entries);
  }
  png_color_16 key{};
  key.gray = static_cast<png_uint_16>(sample(shape, 0, 0, 0));
  if (transparent) {
    png_set_tRNS(png, info, alpha.empty() ? nullptr : alpha.data(), static_cast<int>(alpha.size()), &key);
  }
  png_write_info(png, info);
  png_set_packing(png);  // samples of fewer than 8 bits are given in a byte each
  std::vector<Bytes> rows(kHeight);
  std::vector<png_bytep> pointers;
  for (int y = 0; y < kHeight; ++y) {
    for (int k = 0; k < kWidth * shape.channels(); ++k) {
      const int value = sample(shape, k / shape.channels(), y, k % shape.channels());
      Bytes& row = rows[static_cast<std::size_t>(y)];
      if (shape.depth == 16) row.push_back(static_cast<std::uint8_t>(value >> 8));
      row.push_back(static_cast<std::uint8_t>(value & 255));
    }
  }
  for (Bytes& row : rows) pointers.push_back(row.data());
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

int to_8_bits(const PngShape& shape, int value) {
  const int top = (1 << shape.depth) - 1;
  return (value * 255 + top / 2) / top;
}

class PngShapes : public ::testing::TestWithParam<PngShape> {};

TEST_P(PngShapes, GreyIsTheMeanOfTheColoursAndAlphaIsKept) {
  const PngShape shape = GetParam();
  const GreyImage image = png(encode(shape));
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  ASSERT_EQ(image.alpha.size(), shape.has_alpha() ? image.pixels.size() : 0u);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto channel = [&](int c) { return to_8_bits(shape, sample(shape, x, y, c)); };
      int expected = channel(0);
      if (shape.colour_type == PNG_COLOR_TYPE_PALETTE) {
        const int index = sample(shape, x, y, 0);
        expected = (palette(index, 0) + palette(index, 1) + palette(index, 2) + 1) / 3;
      } else if (shape.channels() >= 3) {
        expected = (channel(0) + channel(1) + channel(2) + 1) / 3;
      }
      const std::size_t k = static_cast<std::size_t>(y * kWidth + x);
      ASSERT_EQ(image.pixels[k], expected) << "pixel " << x << ", " << y;
      if (shape.has_alpha()) {
        ASSERT_EQ(image.alpha[k], channel(shape.channels() - 1)) << "pixel " << x << ", " << y;
      }
    }
  }
}

std::vector<PngShape> all_shapes() {
  std::vector<PngShape> shapes;
  for (const bool interlaced : {false, true}) {
    for (const int depth : {1, 2, 4, 8, 16}) {
      shapes.push_back({PNG_COLOR_TYPE_GRAY, depth, interlaced});
      if (depth <= 8) shapes.push_back({PNG_COLOR_TYPE_PALETTE, depth, interlaced});
      if (depth < 8) continue;
      for (const int type : {PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGBA}) {
        shapes.push_back({type, depth, interlaced});
      }
    }
  }
  return shapes;
}

INSTANTIATE_TEST_SUITE_P(Png, PngShapes, ::testing::ValuesIn(all_shapes()), [](const auto& shape) {
  return "type" + std::to_string(shape.param.colour_type) + "_depth" + std::to_string(shape.param.depth) +
         (shape.param.interlaced ? "_interlaced" : "");
});

TEST(Png, ATransparentColourBecomesAlpha) {
  const PngShape grey{PNG_COLOR_TYPE_GRAY, 4, false};
  const GreyImage image = png(encode(grey, true));
  ASSERT_EQ(image.alpha.size(), image.pixels.size());
  const PngShape indexed{PNG_COLOR_TYPE_PALETTE, 4, true};
  const GreyImage paletted = png(encode(indexed, true));
  ASSERT_EQ(paletted.alpha.size(), paletted.pixels.size());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::size_t k = static_cast<std::size_t>(y * kWidth + x);
      EXPECT_EQ(image.alpha[k], sample(grey, x, y, 0) == sample(grey, 0, 0, 0) ? 0 : 255);
      const int index = sample(indexed, x, y, 0);
      EXPECT_EQ(paletted.alpha[k], index < 8 ? index : 255);
    }
  }
}

/// Replaces the width and height of a PNG, with a correct checksum.
Bytes resized(Bytes bytes, std::uint32_t width, std::uint32_t height) {
  const auto put = [&](std::size_t at, std::uint32_t v) {
    for (std::size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<std::uint8_t>(v >> (24 - 8 * k));
  };
  put(16, width);
  put(20, height);
  put(29, static_cast<std::uint32_t>(crc32(0, bytes.data() + 12, 17)));
  return bytes;
}

const PngShape kPlain{PNG_COLOR_TYPE_GRAY, 8, false};

TEST(Png, ClaimsThatTheFileCannotHoldAreRefusedBeforeAnyAllocation) {
  const Bytes small = encode(kPlain);
  const auto claim = [&](std::uint32_t width, std::uint32_t height) {
    return message_for(resized(small, width, height));
  };
  EXPECT_EQ(claim(60000, 60000), "m.png: image of 60000 x 60000 pixels: expected sides from 1 to 32767");
  EXPECT_EQ(claim(32767, 32767),
            "m.png: truncated PNG: expected at least 1040415 bytes for 32767 x 32767 pixels, found " +
                std::to_string(small.size()));
  EXPECT_EQ(claim(0, 5), "m.png: corrupt PNG: Invalid IHDR data");
}

TEST(Png, EveryTruncationIsAnError) {
  for (const PngShape& shape : {kPlain, PngShape{PNG_COLOR_TYPE_RGBA, 16, true}}) {
    const Bytes whole = encode(shape);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const std::string message = message_for(cut);
      EXPECT_EQ(message.rfind("m.png: corrupt PNG: truncated: expected ", 0), 0u) << size << ": " << message;
    }
  }
}

TEST(Png, EveryFlippedByteOfTheHeaderAndThePixelsIsAnError) {
  const Bytes whole = encode(kPlain);
  const std::string text(whole.begin(), whole.end());
  const std::size_t pixels = text.find("IDAT"), end = text.find("IEND");
  for (std::size_t k = 0; k < end - 4; ++k) {
    if (k >= 33 && k < pixels - 4) continue;  // the gamma: not used, so not checked
    Bytes flipped = whole;
    flipped[k] ^= 0x10;
    message_for(flipped);  // fails unless there is an Error{input}
  }
}

TEST(Png, NamesWhatIsWrong) {
  Bytes bytes = encode(kPlain);
  EXPECT_EQ(message_for({}), "m.png: corrupt PNG: truncated: expected 8 more bytes, found 0");
  EXPECT_EQ(message_for(Bytes(50, 'x')), "m.png: corrupt PNG: Not a PNG file");
  bytes[bytes.size() - 20] ^= 1;  // inside the compressed pixels' checksum
  expect_parts(message_for(bytes), {"m.png: corrupt PNG: IDAT: "});
}

}  // namespace
}  // namespace parloc
