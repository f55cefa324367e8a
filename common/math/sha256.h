// SHA-256 (FIPS 180-4), for digests that two machines can compare by eye.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace parloc {

class Sha256 {
 public:
  Sha256();
  void add(const void* data, std::size_t size);
  /// Little-endian bytes of a number, whatever this machine's order.
  void add(float value);
  void add(double value);
  /// Lower-case hexadecimal; the object can be added to afterwards as if this had not been called.
  std::string hex() const;

 private:
  void block(const std::uint8_t* data);
  std::array<std::uint32_t, 8> state_;
  std::array<std::uint8_t, 64> pending_{};
  std::uint64_t bytes_ = 0;
};

}  // namespace parloc
