// Where the stages of one engine are started: a stream on a device, and scratch memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "cuda/launch.h"
#include "cuda/memory.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Of the collective stages, sized once for a particle count.
struct Scratch {
  DeviceBuffer<double> sums;
  DeviceBuffer<std::uint64_t> best;  // [2] heaviest weight, its smallest key
  DeviceBuffer<std::uint64_t>
      first;                         // adapt: running count of the candidates that are the first in their bin
  DeviceBuffer<unsigned char> scan;  // CUB's
};

class Queue {
 public:
  /// Throws Error{backend} if there is no such device.
  explicit Queue(int device);
  static Queue open(int /*threads*/, int device) { return Queue(device); }
  ~Queue() { free_stream(stream_); }
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  /// Every later call of this host thread is meant for this device: a thread may drive several engines.
  void use() const { select_device(device_); }
  void wait() const { synchronise(stream_); }
  /// Scratch for every stage on so many particles.
  void reserve(std::size_t particles);
  operator Stream() const { return stream_; }
  std::string name() const { return "cuda (" + device_name_ + ")"; }

  Scratch scratch;

 private:
  int device_;
  std::string device_name_;
  Stream stream_{};
};

/// out[i] = in[0] + ... + in[i]; in == out is allowed.
void inclusive_scan(const std::uint64_t* in, std::uint64_t* out, std::size_t count, Queue& queue);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
