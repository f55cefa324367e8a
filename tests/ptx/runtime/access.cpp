// Every access of a kernel to memory comes through here.
#include "tests/ptx/device/access.h"

#include "tests/ptx/runtime/block.h"
#include "tests/ptx/runtime/device_memory.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"

namespace ptx {
namespace {

void check_alignment(const Thread& thread, std::uint64_t address, unsigned bytes) {
  if (address % bytes != 0)
    fault(thread, "misaligned: " + std::to_string(bytes) + " bytes at an address that ends in " +
                      std::to_string(address % 32) + " of 32");
}

/// Bytes of a piece of memory whose addresses start with 0.
char* reach_within(const Thread& thread, char* start, std::uint32_t size, std::uint64_t offset,
                   unsigned bytes, const char* what) {
  if (offset + bytes > size || offset + bytes < bytes)
    fault(thread, std::to_string(bytes) + " bytes out of bounds, at " + std::to_string(offset) + " of " +
                      std::to_string(size) + " bytes of " + what);
  return start + offset;
}

char* reach_global(Thread& thread, std::uint64_t address, unsigned bytes, Access access) {
  DeviceMemory& memory = DeviceMemory::instance();
  if (!memory.holds(address, bytes)) fault(thread, memory.explain(address, bytes));
  if (settings().races) RaceDetector::instance().note_global(thread, memory.place(address), bytes, access);
  return memory.bytes_at(address);
}

char* reach_shared(Thread& thread, std::uint64_t offset, unsigned bytes, Access access) {
  char* at = reach_within(thread, thread.shared, thread.shared_bytes, offset, bytes, "shared memory");
  if (settings().races)
    RaceDetector::instance().note_shared(thread, thread.block->memory->traces,
                                         static_cast<std::uint32_t>(offset), bytes, access);
  return at;
}

}  // namespace

char* reach(Thread& thread, Space space, std::uint64_t address, unsigned bytes, Access access) {
  if (space == Space::generic) {
    const std::uint64_t window = address & kWindowBits;
    space = window == kSharedWindow      ? Space::shared
            : window == kLocalWindow     ? Space::local
            : window == kParameterWindow ? Space::parameter
                                         : Space::global;
    if (space != Space::global) address -= window;
  }
  check_alignment(thread, address, bytes);
  switch (space) {
    case Space::shared:
      return reach_shared(thread, address, bytes, access);
    case Space::local:
      return reach_within(thread, thread.local, thread.local_bytes, address, bytes, "local memory");
    case Space::parameter:
      return reach_within(thread, thread.parameters,
                          static_cast<std::uint32_t>(thread.launch->parameters.size()), address, bytes,
                          "parameters");
    default:
      return reach_global(thread, address, bytes, access);
  }
}

void fence(Thread& thread) {
  if (settings().races) note_fence(thread);
}

void refuse(const Thread& thread, const char* why) {
  fault(thread, why);
}

}  // namespace ptx
