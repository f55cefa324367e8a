// Device memory, and stages that run when the host does not wait for them: what the engines
// (common/filter/engine/filter_engine.h and its sisters) are given to run on CUDA.
#pragma once

#include <map>
#include <memory>

#include "cuda/flow_stages.h"
#include "cuda/slam_stages.h"
#include "cuda/stages.h"
#include "cuda/step_group.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Memory that the host fills in or reads, and the stages too; send() and fetch() copy.
template <class T>
class Mirror {
 public:
  void reserve(std::size_t size) {
    there_.reserve(size);  // first: size() is of what both have
    host_.reserve(size);
  }
  T* host() { return host_.data(); }
  const T* host() const { return host_.data(); }
  T* there() { return there_.data(); }
  const T* there() const { return there_.data(); }
  std::size_t size() const { return host_.size(); }
  void send(Stream stream) { copy_down(there_.data(), host_.data(), size() * sizeof(T), stream); }
  void fetch(Stream stream) { copy_up(host_.data(), there_.data(), size() * sizeof(T), stream); }

 private:
  HostBuffer<T> host_;
  DeviceBuffer<T> there_;
};

/// Kinds of work that repeat, by number.
class Recordings {
 public:
  template <class Work>
  void run(unsigned kind, const Queue& queue, const Work& work) {
    kinds_[kind].run(queue, work);
  }
  /// Runs it, and waits: alone, or together with the steps of other filters.
  template <class Work>
  void finish(unsigned kind, const Queue& queue, const Work& work) {
    if (queue.group() == nullptr) {
      run(kind, queue, work);
      return queue.wait();
    }
    std::unique_ptr<JoinedSequence>& joined = joined_[kind];
    if (joined == nullptr) joined = std::make_unique<JoinedSequence>(*queue.group(), queue, work);
    joined->run();
  }
  /// After memory has moved that they know.
  void forget() {
    kinds_.clear();
    joined_.clear();
  }

 private:
  std::map<unsigned, Repeated> kinds_;
  std::map<unsigned, std::unique_ptr<JoinedSequence>> joined_;
};

struct Space : FilterStages, FlowStages, SlamStages {
  using Queue = PARLOC_CUDA_NAMESPACE::Queue;
  using Recordings = PARLOC_CUDA_NAMESPACE::Recordings;
  using FlowRoom = PARLOC_CUDA_NAMESPACE::FlowRoom;
  using TileStore = PARLOC_CUDA_NAMESPACE::TileStore;
  using NewTiles = PARLOC_CUDA_NAMESPACE::NewTiles;
  template <class T>
  using Array = DeviceBuffer<T>;
  template <class T>
  using Mirror = PARLOC_CUDA_NAMESPACE::Mirror<T>;

  /// A skip field by sector up to this size: 8 M cells. Its planes do not fit the first-level caches, and
  /// yet it is worth it: a third of the leaps, and lanes of a warp that end together (docs/results/gpu.md).
  static constexpr std::size_t kMostSkipBytes = std::size_t{2} << 30;
  static constexpr bool kGivesUpEarly = false;
  /// Cumulative weights are sums within blocks, and what comes before each block: whoever looks one up adds
  /// the two, so that no kernel has to come between to do it for all.
  static constexpr bool kSumsInBlocks = true;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
