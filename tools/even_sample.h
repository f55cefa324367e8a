// Keeps items from several times of a work whose length is not known beforehand.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace parloc::tools {

/// Takes every stride-th item; when there are more than `most`, every other one is dropped and the stride
/// doubled. So they are even over the work, their memory is bounded, and which ones they are depends on the
/// count of steps alone.
template <class Item>
class EvenSample {
 public:
  /// `most` is even.
  explicit EvenSample(std::size_t most) : most_(most) {}

  /// After each step; make() is called if its item is kept.
  template <class Make>
  void offer(Make make) {
    last_kept_ = offered_++ % stride_ == 0;
    if (!last_kept_) return;
    kept_.push_back(make());
    if (kept_.size() <= most_) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < kept_.size(); i += 2) {
      if (kept != i) kept_[kept] = std::move(kept_[i]);
      ++kept;
    }
    kept_.resize(kept);  // `most` is even, so the newest is among them
    stride_ *= 2;
  }
  /// After the last step, which is always kept, be there one more than `most`.
  template <class Make>
  void finish(Make make) {
    if (!last_kept_) kept_.push_back(make());
  }
  std::vector<Item> take() { return std::move(kept_); }

 private:
  std::size_t most_;
  std::vector<Item> kept_;
  std::size_t stride_ = 1;
  std::size_t offered_ = 0;
  bool last_kept_ = false;
};

}  // namespace parloc::tools
