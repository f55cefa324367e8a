// The device's memory. Its addresses are numbers that no page of the host lies behind, so that a host that
// reads or writes them dies; the executor finds the bytes elsewhere. No address is given twice, so that freed
// memory stays known as such.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace ptx {

class DeviceMemory {
 public:
  static DeviceMemory& instance();

  /// Filled with poison. 0 where there is not so much left.
  std::uint64_t allocate(std::size_t bytes);
  /// False if there is no live allocation with this address.
  bool free(std::uint64_t address);
  /// Whether all of these bytes lie in one live allocation.
  bool holds(std::uint64_t address, std::size_t bytes) const {
    const Piece* piece = piece_at(address);
    return piece != nullptr && piece->live && address + bytes <= piece->end;
  }
  /// Whether the address is one of the device's, live or not.
  bool is_device(std::uint64_t address) const { return address - first_ < kSpace; }
  /// Where on the host the bytes are.
  char* bytes_at(std::uint64_t address) const { return bytes_ + (address - first_); }
  /// Bytes before this one, in all of the address space: what the race detector counts by.
  std::uint64_t place(std::uint64_t address) const { return address - first_; }
  /// For a message: why holds() is false.
  std::string explain(std::uint64_t address, std::size_t bytes) const;

  static constexpr std::uint64_t kSpace = 1ull << 36;

 private:
  struct Piece {
    std::uint64_t begin, end;
    bool live;
  };
  static constexpr std::uint64_t kPage = 4096;

  DeviceMemory();
  /// The allocation that the page of this address belongs to.
  const Piece* piece_at(std::uint64_t address) const {
    if (!is_device(address)) return nullptr;
    const std::uint32_t owner = owners_[(address - first_) / kPage];
    return owner == 0 ? nullptr : &pieces_[owner - 1];
  }

  std::uint64_t first_ = 0;
  char* bytes_ = nullptr;
  std::uint32_t* owners_ = nullptr;  // of every page: the number of its piece, from 1
  Piece* pieces_ = nullptr;
  std::uint32_t count_ = 0;
  std::uint64_t used_ = 0;  // of the address space
  std::uint64_t held_ = 0;  // by live pieces
};

/// Memory of the host, zero, that costs nothing until it is touched. Ends the program where there is none.
void* reserve_pages(std::size_t bytes, bool accessible);

}  // namespace ptx
