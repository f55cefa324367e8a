#include "tests/ptx/runtime/device_memory.h"

#include <sys/mman.h>

#include <csignal>
#include <cstring>

#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

constexpr int kPoison = 0xCD;

/// Says so if it was the host that touched the device's memory; otherwise the program ends as it would have.
void on_bad_address(int signal, siginfo_t* info, void*) {
  const auto address = reinterpret_cast<std::uint64_t>(info->si_addr);
  if (DeviceMemory::instance().is_device(address)) fault("the host touched memory of the device");
  std::signal(signal, SIG_DFL);
}

}  // namespace

void* reserve_pages(std::size_t bytes, bool accessible) {
  void* pages = mmap(nullptr, bytes, accessible ? PROT_READ | PROT_WRITE : PROT_NONE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pages == MAP_FAILED) fault("no address space of " + std::to_string(bytes >> 20) + " MiB");
  return pages;
}

DeviceMemory& DeviceMemory::instance() {
  static DeviceMemory memory;
  return memory;
}

DeviceMemory::DeviceMemory()
    : first_(reinterpret_cast<std::uint64_t>(reserve_pages(kSpace, false))),
      bytes_(static_cast<char*>(reserve_pages(kSpace, true))),
      owners_(static_cast<std::uint32_t*>(reserve_pages(kSpace / kPage * sizeof(std::uint32_t), true))),
      pieces_(static_cast<Piece*>(reserve_pages(kSpace / kPage * sizeof(Piece), true))) {
  struct sigaction action {};
  action.sa_sigaction = on_bad_address;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSEGV, &action, nullptr);
}

std::uint64_t DeviceMemory::allocate(std::size_t bytes) {
  if (bytes > settings().memory || held_ + bytes > settings().memory) return 0;
  const std::uint64_t pages = bytes / kPage + 1;  // what lies behind the last byte belongs to nobody
  if (used_ + (pages + 1) * kPage > kSpace)
    fault("the program has allocated more memory in all than there are addresses");
  const std::uint64_t begin = first_ + used_;
  pieces_[count_++] = {begin, begin + bytes, true};
  for (std::uint64_t page = 0; page < pages; ++page) owners_[used_ / kPage + page] = count_;
  used_ += (pages + 1) * kPage;
  held_ += bytes;
  std::memset(bytes_at(begin), kPoison, bytes);
  return begin;
}

bool DeviceMemory::free(std::uint64_t address) {
  const Piece* found = piece_at(address);
  if (found == nullptr || found->begin != address || !found->live) return false;
  Piece& piece = pieces_[found - pieces_];
  piece.live = false;
  held_ -= piece.end - piece.begin;
  madvise(bytes_at(address), piece.end - piece.begin, MADV_DONTNEED);
  return true;
}

std::string DeviceMemory::explain(std::uint64_t address, std::size_t bytes) const {
  const Piece* piece = piece_at(address);
  const std::string what = std::to_string(bytes) + " bytes ";
  if (!is_device(address))
    return what + (address < kPage ? "behind a null pointer" : "that are no memory of the device");
  if (piece == nullptr) return what + "outside of every allocation";
  const std::string of = std::to_string(piece->end - piece->begin) + " bytes";
  if (!piece->live) return what + "of freed memory, an allocation of " + of;
  return what + "out of bounds, at " + std::to_string(address - piece->begin) + " of an allocation of " + of;
}

}  // namespace ptx
