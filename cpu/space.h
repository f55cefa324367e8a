// Host memory, and stages that are done when they return: what the engines
// (common/filter/engine/filter_engine.h and its sisters) are given to run on OpenMP.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/math/zeroed_vector.h"
#include "cpu/flow_stages.h"
#include "cpu/slam_stages.h"
#include "cpu/stages.h"

namespace parloc::cpu {

/// Grows only, and then is zero where it has grown.
template <class T>
class Array {
 public:
  void reserve(std::size_t size) {
    if (size > values_.size()) values_.resize(size);
  }
  void from_host(const std::vector<T>& host, const Queue&) {
    reserve(host.size());
    std::copy(host.begin(), host.end(), values_.begin());
  }
  /// As from_host, where the host needs it no more.
  void take(const std::vector<T>& host, const Queue&) { values_ = ZeroedVector<T>(host.begin(), host.end()); }
  void take(ZeroedVector<T>&& host, const Queue&) { values_ = std::move(host); }
  std::vector<T> to_host(std::size_t count, const Queue&, std::size_t first = 0) const {
    const auto from = values_.begin() + static_cast<std::ptrdiff_t>(first);
    return {from, from + static_cast<std::ptrdiff_t>(count)};
  }
  T* data() { return values_.data(); }
  std::size_t size() const { return values_.size(); }
  void swap(Array& other) { values_.swap(other.values_); }

 private:
  ZeroedVector<T> values_;
};

/// Memory that the host fills in or reads, and the stages too: the same for both.
template <class T>
class Mirror {
 public:
  void reserve(std::size_t size) {
    if (size > values_.size()) values_.resize(size);
  }
  T* host() { return values_.data(); }
  const T* host() const { return values_.data(); }
  T* there() { return values_.data(); }
  const T* there() const { return values_.data(); }
  std::size_t size() const { return values_.size(); }
  void send(const Queue&) {}
  void fetch(const Queue&) {}

 private:
  std::vector<T> values_;
};

/// Work that repeats is simply done again.
struct Recordings {
  template <class Work>
  void run(unsigned, const Queue&, const Work& work) {
    work();
  }
  template <class Work>
  void finish(unsigned, const Queue&, const Work& work) {
    work();
  }
  void forget() {}
};

struct Space : FilterStages, FlowStages, SlamStages {
  using Queue = cpu::Queue;
  using Recordings = cpu::Recordings;
  using FlowRoom = cpu::FlowRoom;
  using TileStore = cpu::TileStore;
  using NewTiles = cpu::NewTiles;
  template <class T>
  using Array = cpu::Array<T>;
  template <class T>
  using Mirror = cpu::Mirror<T>;

  /// A skip field by sector is worth it even out of the caches: 13 times on the office floor (25 MB).
  static constexpr std::size_t kMostSkipBytes = std::size_t{2} << 30;
  /// A particle is given up as soon as it cannot win any more: its first beams should tell most.
  static constexpr bool kGivesUpEarly = true;
  /// Cumulative weights are plain sums.
  static constexpr bool kSumsInBlocks = false;
};

}  // namespace parloc::cpu
