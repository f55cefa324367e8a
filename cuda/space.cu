#include "cuda/space.h"

#include <algorithm>
#include <cstring>

#include "common/filter/filter_backend.h"
#include "cuda/block_sum.h"
#include "cuda/scan.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

#if defined(__CUDACC__)
std::string usable_device(int device) {
  const int devices = cuda_device_count();
  if (devices == 0)
    throw Error(ErrorKind::backend,
                "backend cuda: no CUDA device answers (no GPU, or no driver); use --backend cpu");
  if (device < 0 || device >= devices)
    throw Error(ErrorKind::backend, "backend cuda: there is no device " + std::to_string(device) +
                                        "; parloc devices lists " + std::to_string(devices));
  cudaDeviceProp p{};
  PARLOC_CHECK(cudaGetDeviceProperties(&p, device), "reading the device's properties");
  return p.name;
}
#else
std::string usable_device(int) {
  return "kernels on the host";
}
#endif

/// From or to the piece of memory that is copied for all.
struct CopyWords {
  std::uint32_t* to;
  const std::uint32_t* from;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < count; i += me.stride()) to[i] = from[i];
  }
};
const KernelKind& kind_of_piece(const Sequence::Piece& p) {
  return p.what == Sequence::Do::kernel ? *p.kind : kind_of<CopyWords>;
}
unsigned blocks_of(const Sequence::Piece& p) {
  return p.what == Sequence::Do::kernel ? p.blocks : blocks_for(p.bytes / sizeof(std::uint32_t));
}
std::uint32_t* as_words(unsigned char* bytes) {
  return reinterpret_cast<std::uint32_t*>(bytes);
}

std::shared_ptr<StepGroup> group_on(int device, const std::shared_ptr<FilterGroup>& group) {
  auto ours = std::dynamic_pointer_cast<StepGroup>(group);
  if (group != nullptr && (ours == nullptr || ours->device() != device))
    throw Error(ErrorKind::backend, "backend cuda: expected a group of filters on device " +
                                        std::to_string(device) + ", got one that is elsewhere");
  return ours;
}

struct ReadValue {
  const std::uint64_t* from;
  PARLOC_HD std::uint64_t operator()(std::size_t i) const { return from[i]; }
};

struct AddBefore {
  std::uint64_t* sums;
  const std::uint64_t* before;
  std::size_t count;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < count; i += me.stride()) sums[i] += before[i / kSumBlock];
  }
};

}  // namespace

Queue::Queue(int device, const std::shared_ptr<FilterGroup>& group)
    : device_(device), device_name_(usable_device(device)), group_(group_on(device, group)) {
  use();  // before anything is allocated
  stream_ = group_ != nullptr ? share_stream(group_->stream()) : make_stream();
  scratch.arrived.from_host({0}, stream_);
  scratch.largest.from_host({LargestWeight{}}, stream_);
  scratch.heaviest.reserve(2 * kHeaviestBlocks + 1);
}

StepGroup::StepGroup(int device) : device_(device) {
  usable_device(device);
  select_device(device);
  stream_ = make_stream();
}

StepGroup::Bytes StepGroup::room_of(const Sequence& sequence) {
  Bytes room;
  for (const Sequence::Piece& p : sequence.pieces()) {
    room.down += kind_of_piece(p).bytes;
    if (p.what == Sequence::Do::copy_down) room.down += Sequence::aligned(p.bytes);
    if (p.what == Sequence::Do::copy_up) room.up += Sequence::aligned(p.bytes);
  }
  return room;
}

void StepGroup::join(const Sequence& sequence) {
  const Bytes more = room_of(sequence);
  const std::lock_guard lock(room_mutex_);
  const Bytes all{room_.down + more.down, room_.up + more.up};
  if (!down_.holds(all.down) || !up_.holds(all.up))
    gathering_.between([&] {  // twice as much, so that this is seldom
      down_.reserve(2 * all.down);
      up_.reserve(2 * all.up);
    });
  room_ = all;
}
void StepGroup::leave(const Sequence& sequence) noexcept {
  const Bytes less = room_of(sequence);
  const std::lock_guard lock(room_mutex_);
  room_.down -= less.down, room_.up -= less.up;
}
void StepGroup::run(const Sequence& sequence) {
  gathering_.ask(sequence, Sequence::alike, [this](const Sequences& sequences) { run_batch(sequences); });
}

void StepGroup::run_batch(const Sequences& sequences) {
  select_device(device_);
  const Bytes used = fill(sequences);
  copy_down(down_.there.data(), down_.host.data(), used.down, stream_);
  start(sequences);
  if (used.up > 0) copy_up(up_.host.data(), up_.there.data(), used.up, stream_);
  synchronise(stream_);
  hand_out(sequences);
  steps_ += sequences.size();
  ++batches_;
}

/// The members of the first kernel of all lists, those of the second and so on, and behind them what the host
/// gives them.
StepGroup::Bytes StepGroup::fill(const Sequences& sequences) {
  Bytes next;
  for (const Sequence::Piece& p : sequences[0]->pieces())
    next.down += sequences.size() * kind_of_piece(p).bytes;
  unsigned char* to = down_.host.data();
  for (std::size_t k = 0; k < sequences[0]->pieces().size(); ++k)
    for (const Sequence* const sequence : sequences) {
      const Sequence::Piece& p = sequence->pieces()[k];
      Member<CopyWords> copy{{nullptr, nullptr, p.bytes / sizeof(std::uint32_t)}, blocks_of(p)};
      if (p.what == Sequence::Do::copy_down) {
        std::memcpy(down_.host.data() + next.down, p.host, p.bytes);
        copy.kernel.from = as_words(down_.there.data() + next.down);
        copy.kernel.to = static_cast<std::uint32_t*>(p.device);
        next.down += Sequence::aligned(p.bytes);
      } else if (p.what == Sequence::Do::copy_up) {
        copy.kernel.from = static_cast<std::uint32_t*>(p.device);
        copy.kernel.to = as_words(up_.there.data() + next.up);
        next.up += Sequence::aligned(p.bytes);
      }
      const void* const member =
          p.what == Sequence::Do::kernel ? sequence->member(p) : static_cast<void*>(&copy);
      std::memcpy(to, member, kind_of_piece(p).bytes);
      to += kind_of_piece(p).bytes;
    }
  return next;
}

void StepGroup::start(const Sequences& sequences) {
  const unsigned char* members = down_.there.data();
  for (std::size_t k = 0; k < sequences[0]->pieces().size(); ++k) {
    const KernelKind& kind = kind_of_piece(sequences[0]->pieces()[k]);
    unsigned most_blocks = 0;
    for (const Sequence* const sequence : sequences)
      most_blocks = std::max(most_blocks, blocks_of(sequence->pieces()[k]));
    kind.start(members, most_blocks, static_cast<unsigned>(sequences.size()), stream_);
    members += sequences.size() * kind.bytes;
  }
}

/// In the order in which fill() has placed them.
void StepGroup::hand_out(const Sequences& sequences) const {
  const unsigned char* from = up_.host.data();
  for (std::size_t k = 0; k < sequences[0]->pieces().size(); ++k)
    for (const Sequence* const sequence : sequences) {
      const Sequence::Piece& p = sequence->pieces()[k];
      if (p.what != Sequence::Do::copy_up) break;
      std::memcpy(p.host, from, p.bytes);
      from += Sequence::aligned(p.bytes);
    }
}

void Queue::reserve(std::size_t particles) {
  const std::size_t blocks = sum_blocks(particles);
  const SumShape shape = SumShape::of(blocks);
  const std::size_t sums = (shape.parts > 1 ? shape.parts * blocks : 0) + blocks + sum_blocks(blocks) + 3;
  scratch.sums.reserve(sums * 12);  // the widest sum has 12 terms
  scratch.before.reserve(blocks);
}

void inclusive_scan(std::uint64_t* sums, std::size_t count, Queue& queue) {
  if (count == 0) return;
  queue.scratch.before.reserve(sum_blocks(count));
  std::uint64_t* const before = queue.scratch.before.data();
  scan_in_blocks(ReadValue{sums}, count, sums, before, queue);
  if (count > kSumBlock) launch_step(AddBefore{sums, before, count}, blocks_for(count), queue);
}

}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
int cuda_device_count() {
  int count = 0;
  if (cudaGetDeviceCount(&count) != cudaSuccess) {
    (void)cudaGetLastError();
    return 0;
  }
  return count;
}

std::vector<std::string> describe_cuda_devices() {
  std::vector<std::string> lines;
  for (int d = 0; d < cuda_device_count(); ++d) {
    cudaDeviceProp p{};
    PARLOC_CHECK(cudaGetDeviceProperties(&p, d), "reading a device's properties");
    lines.push_back("cuda " + std::to_string(d) + ": " + std::string(p.name) + ", compute capability " +
                    std::to_string(p.major) + "." + std::to_string(p.minor) + ", " +
                    std::to_string(p.totalGlobalMem >> 20) + " MiB");
  }
  if (lines.empty()) lines.push_back("cuda: built, but no device answers (no GPU, or no driver)");
  return lines;
}
#endif

}  // namespace parloc
