// A filter's step as a list: its kernels with their members, and its copies from and to the host. The lists
// of many filters are worked off together (cuda/step_group.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "cuda/stream.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// How a kernel is started for many filters at once. There is one of each type of kernel.
struct KernelKind {
  std::size_t bytes;  ///< Of a Member (cuda/launch.h).
  void (*start)(const void* members, unsigned most_blocks, unsigned count, Stream stream);
};

class Sequence {
 public:
  enum class Do { kernel, copy_down, copy_up };
  struct Piece {
    Do what;
    const KernelKind* kind = nullptr;  ///< Of a kernel; which blocks, and where its Member begins.
    unsigned blocks = 0;
    std::size_t member = 0;
    void* device = nullptr;  ///< Of a copy.
    void* host = nullptr;
    std::size_t bytes = 0;  ///< Of either.
  };
  static constexpr std::size_t kAlignment = 16;
  static std::size_t aligned(std::size_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

  void add_kernel(const KernelKind& kind, const void* member, unsigned blocks) {
    const auto* bytes = static_cast<const unsigned char*>(member);
    pieces_.push_back({.what = Do::kernel, .kind = &kind, .blocks = blocks, .member = members_.size()});
    pieces_.back().bytes = kind.bytes;
    members_.insert(members_.end(), bytes, bytes + kind.bytes);
  }
  /// The host's memory is read anew each time, and must stay.
  void add_copy_down(void* device, const void* host, std::size_t bytes) {
    pieces_.push_back(
        {.what = Do::copy_down, .device = device, .host = const_cast<void*>(host), .bytes = bytes});
  }
  void add_copy_up(void* host, const void* device, std::size_t bytes) {
    pieces_.push_back(
        {.what = Do::copy_up, .device = const_cast<void*>(device), .host = host, .bytes = bytes});
  }

  const std::vector<Piece>& pieces() const { return pieces_; }
  const unsigned char* member(const Piece& piece) const { return members_.data() + piece.member; }

  /// Whether both do the same kinds of things in the same order, so that each step of theirs is one launch.
  static bool alike(const Sequence& a, const Sequence& b) {
    const auto same = [](const Piece& x, const Piece& y) { return x.what == y.what && x.kind == y.kind; };
    return std::equal(a.pieces_.begin(), a.pieces_.end(), b.pieces_.begin(), b.pieces_.end(), same);
  }

 private:
  std::vector<Piece> pieces_;
  std::vector<unsigned char> members_;
};

inline Sequence* noted_by(Stream stream) {
  return stream != nullptr ? stream->noting : nullptr;
}

/// While it lives, what is started on the stream is noted and not done.
class Noting {
 public:
  Noting(Stream stream, Sequence& sequence) : stream_(stream) { stream->noting = &sequence; }
  ~Noting() { stream_->noting = nullptr; }
  Noting(const Noting&) = delete;
  Noting& operator=(const Noting&) = delete;

 private:
  Stream stream_;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
