// The step input and the beams of the scan where the host fills them in and where the stages read them.
#pragma once

#include <algorithm>
#include <cstddef>

#include "common/filter/stages.h"
#include "common/model/beams.h"

namespace parloc {

/// `Input`: a StepInput, or one with more in it.
template <class Space, class Input = StepInput>
class StepInputBuffer {
 public:
  StepInputBuffer() { grow(0); }

  Input& host() { return *reinterpret_cast<Input*>(memory_.host()); }
  /// In the backend's space, as send() brought it there.
  const Input* input() const { return reinterpret_cast<const Input*>(memory_.there()); }

  /// Whether the arrays stay where they are when this scan is set.
  bool has_room_for(const BeamTable& t) const { return t.count <= capacity_; }
  void set_scan(const BeamTable& t) {
    if (!has_room_for(t)) grow(t.count);
    host().scan = t;
    for (std::size_t k = 0; k < kBeamArrays.size(); ++k)
      std::copy((t.*kBeamArrays[k]).begin(), (t.*kBeamArrays[k]).end(), array(memory_.host(), k));
  }

  /// Beams that there is room for.
  std::size_t capacity() const { return capacity_; }

  void send(typename Space::Queue& queue) { memory_.send(queue); }

  /// Where the arrays are in the backend's space, with the shape that the host knows.
  Beams beams() {
    const auto at = [this](std::size_t k) { return array(memory_.there(), k); };
    return {host().scan, at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)};
  }

 private:
  float* array(unsigned char* memory, std::size_t k) const {
    return reinterpret_cast<float*>(memory + sizeof(Input)) + k * capacity_;
  }
  void grow(std::size_t beams) {
    const Input kept = memory_.size() == 0 ? Input{} : host();
    const std::size_t capacity = (beams + 15) / 16 * 16;  // whole vectors
    memory_.reserve(sizeof(Input) + kBeamArrays.size() * capacity * sizeof(float));
    capacity_ = capacity;
    std::fill_n(memory_.host(), memory_.size(), static_cast<unsigned char>(0));
    host() = kept;
  }

  std::size_t capacity_ = 0;
  typename Space::template Mirror<unsigned char> memory_;
};

}  // namespace parloc
