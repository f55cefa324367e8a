// What the written kernels know of their surroundings: the thread that runs, and what it waits for. A kernel
// is a function of one thread. Where threads meet (a barrier, an instruction of a warp) it returns to the
// scheduler with its registers kept, and goes on behind that instruction when it is called again.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace ptx {

/// Why a kernel's function returned.
enum class Outcome { finished, barrier, warp, yielded };

/// Kinds of instructions, as they are counted.
enum Kind { kInteger, kFloat32, kFloat64, kGlobal, kShared, kOther, kAtomic, kMeeting, kControl, kKinds };
inline constexpr std::array<const char*, kKinds> kKindNames{
    "integer", "float32", "float64", "global", "shared", "other memory", "atomic", "meeting", "control"};

struct Extent {
  std::uint32_t x = 1, y = 1, z = 1;
  std::uint64_t all() const { return std::uint64_t{x} * y * z; }
};

struct Kernel;
struct Launch {
  const Kernel* kernel;
  Extent blocks, threads;
  std::uint32_t dynamic_shared = 0;
  std::uint32_t number = 0;  // counted from 1
  std::vector<char> parameters;
};

/// What a thread asks of its warp, or of its block at a barrier, and the answer.
enum class Request {
  sync,
  shuffle_up,
  shuffle_down,
  shuffle_across,  // bfly
  shuffle_from,    // idx
  vote_all,
  vote_any,
  vote_uniform,
  ballot,
  match_any,
  match_all,
  reduce_add,
  reduce_min,
  reduce_max,
  reduce_and,
  reduce_or,
  reduce_xor,
  count,  // of a barrier: of the threads whose predicate is true
};
struct Meeting {
  Request request = Request::sync;
  int line = 0;
  std::uint32_t mask = 0;   // of a warp: who takes part
  std::uint64_t value = 0;  // what the thread brings
  std::uint32_t lane = 0;   // of a shuffle: which lane
  std::uint32_t bound = 0;  // of a shuffle: the edges of its segments
  bool is_signed = false;   // of a reduction
  std::uint32_t barrier = 0, expected = 0;
  std::uint64_t result = 0;
  bool predicate = false;
};

struct Block;
struct Knowledge;

struct Thread {
  const Launch* launch = nullptr;
  Block* block = nullptr;
  Extent id, block_id;
  std::uint32_t index = 0;  // within the block
  char* parameters = nullptr;
  char* shared = nullptr;
  char* local = nullptr;
  std::uint32_t shared_bytes = 0, local_bytes = 0;
  int line = 0;      // of the PTX, where the thread is
  int patience = 0;  // how many reads that may wait for another thread it does before it lets others run
  Meeting meeting;
  std::uint32_t* visits = nullptr;  // how often the thread came to each piece of its kernel

  // For the race detector: the thread's own time, and up to which time it knows its block and its warp.
  std::uint32_t clock = 1, block_seen = 0;
  std::array<std::uint32_t, 32> warp_seen{};
  std::shared_ptr<const Knowledge> known, released;

  std::uint32_t lane() const { return index % 32; }
  std::uint32_t warp() const { return index / 32; }
  std::uint32_t lanes_at_or_above() const { return ~0u << lane(); }
  std::uint32_t lanes_below() const { return (1u << lane()) - 1; }
  void visit(unsigned piece) { ++visits[piece]; }
  /// True every so often: let others run now.
  bool lets_others_run() { return --patience < 0; }
};

/// The bits of a value as a value of another type of that size.
template <class To, class From>
To bits(From from) {
  return std::bit_cast<To>(from);
}

/// A piece of a kernel, to be run through from its first instruction to its last: how many there are of a
/// kind.
using Piece = std::array<std::uint16_t, kKinds>;

/// A kernel, as the generator wrote it.
struct Parameter {
  std::uint32_t offset, size;
};
struct Kernel {
  const char* name;  // without the numbers that nvcc makes of a file's path (runtime/names.h)
  const char* file;
  Outcome (*run)(Thread&, void* registers);
  std::uint32_t register_bytes, shared_bytes, local_bytes, parameter_bytes, max_threads;
  const Parameter* parameters;
  const Piece* pieces;
  std::uint32_t piece_count;
  bool meets;  // its threads stop before they are finished
  bool has_fence;
};
/// A variable of a module in global or constant memory; `address` is set when the program starts.
struct Symbol {
  const char* name;
  std::uint32_t size, align;
  const unsigned char* initial;
  std::uint64_t address;
};
struct Module {
  const Kernel* kernels;
  std::size_t kernel_count;
  Symbol* symbols;
  std::size_t symbol_count;
};
/// Ends with a null pointer.
extern const Module* const modules[];

}  // namespace ptx
