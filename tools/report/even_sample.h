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
  const std::vector<Item>& kept() const { return kept_; }
  std::vector<Item> take() { return std::move(kept_); }

  /// Goes on as after `offered` steps, of which `kept` was kept; whether it could be so.
  bool restore(std::vector<Item> kept, std::size_t offered) {
    const std::size_t last = offered == 0 ? 0 : offered - 1;
    stride_ = 1;
    while (last / stride_ >= most_) stride_ *= 2;
    offered_ = offered;
    last_kept_ = offered > 0 && last % stride_ == 0;
    kept_ = std::move(kept);
    return kept_.size() == (offered == 0 ? 0 : last / stride_ + 1);
  }

 private:
  std::size_t most_;
  std::vector<Item> kept_;
  std::size_t stride_ = 1;
  std::size_t offered_ = 0;
  bool last_kept_ = false;
};

}  // namespace parloc::tools
