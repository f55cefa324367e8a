// Any bytes are a PNG image with all of its pixels, or an Error{input} of one line. Each input is read as it
// is, and once more with the checksums of its chunks put right: behind a wrong one, libpng looks at nothing.

#include "tests/fuzz/image_fuzz.h"

namespace {

std::uint32_t big_endian(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 |
         std::uint32_t{p[3]};
}

/// CRC-32 of PNG (ISO 3309), bit by bit: the inputs are small.
std::uint32_t checksum(const std::uint8_t* data, std::size_t size) {
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t k = 0; k < size; ++k) {
    crc ^= data[k];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return ~crc;
}

/// A chunk is: length, type, `length` bytes, checksum of type and bytes.
void correct_checksums(std::vector<std::uint8_t>& png) {
  std::size_t at = 8;  // after the signature
  while (png.size() >= at + 12 && big_endian(&png[at]) <= png.size() - at - 12) {
    const std::size_t length = big_endian(&png[at]);
    const std::uint32_t crc = checksum(&png[at + 4], length + 4);
    for (std::size_t k = 0; k < 4; ++k)
      png[at + 8 + length + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
    at += 12 + length;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::check_image(parloc::read_png, data, size);
  std::vector<std::uint8_t> corrected(data, data + size);
  correct_checksums(corrected);
  parloc::fuzz::check_image(parloc::read_png, corrected.data(), corrected.size());
  return 0;
}
