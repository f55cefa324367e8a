// Steps of many filters at once: for each position of their lists one launch, whose blocks are those of all.
// One copy brings what the kernels of all of them need, and one what the hosts' threads wait for.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>

#include "common/filter/filter_group.h"
#include "cuda/gathering.h"
#include "cuda/memory.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// One stream for all. What a filter asks for outside of its steps goes there as well, and so is done before
/// its next step. Thread-safe.
class StepGroup final : public FilterGroup {
 public:
  /// Throws Error{backend} if there is no such device.
  explicit StepGroup(int device);
  ~StepGroup() override { free_stream(stream_); }
  StepGroup(const StepGroup&) = delete;
  StepGroup& operator=(const StepGroup&) = delete;

  int device() const { return device_; }
  Stream stream() const { return stream_; }
  FilterGroupCounts counts() const override { return {steps_, batches_}; }

  /// How many steps wait for the batch that is being done.
  std::size_t waiting() const { return gathering_.waiting(); }

  /// Room for one more such list in a batch. Throws Error{backend} if there is no memory for it, and the
  /// group is as it was.
  void join(const Sequence& sequence);
  void leave(const Sequence& sequence) noexcept;
  /// Does the list, which has joined, and waits for it.
  void run(const Sequence& sequence);

 private:
  using Sequences = Gathering<Sequence>::Items;
  struct Staging {
    HostBuffer<unsigned char> host;
    DeviceBuffer<unsigned char> there;
    bool holds(std::size_t bytes) const { return bytes <= host.size() && bytes <= there.size(); }
    void reserve(std::size_t bytes) {
      there.reserve(bytes);
      host.reserve(bytes);
    }
  };
  /// Bytes that go down and that come up: room for them, or so many are in use.
  struct Bytes {
    std::size_t down = 0, up = 0;
  };

  static Bytes room_of(const Sequence& sequence);
  void run_batch(const Sequences& sequences);
  Bytes fill(const Sequences& sequences);
  void start(const Sequences& sequences);
  void hand_out(const Sequences& sequences) const;

  int device_;
  Stream stream_{};
  Gathering<Sequence> gathering_;
  std::mutex room_mutex_;  // of the next; a batch only needs the memory, which changes between batches
  Bytes room_;             // that all lists take that have joined
  Staging down_, up_;      // as large as that
  std::atomic<std::uint64_t> steps_ = 0, batches_ = 0;
};

/// A list that has joined a group, as long as it lives.
class JoinedSequence {
 public:
  template <class Work>
  JoinedSequence(StepGroup& group, Stream stream, const Work& work) : group_(group) {
    {
      const Noting noting(stream, sequence_);
      work();
    }
    group_.join(sequence_);
  }
  ~JoinedSequence() { group_.leave(sequence_); }
  JoinedSequence(const JoinedSequence&) = delete;
  JoinedSequence& operator=(const JoinedSequence&) = delete;
  void run() const { group_.run(sequence_); }

 private:
  StepGroup& group_;
  Sequence sequence_;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
