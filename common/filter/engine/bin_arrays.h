// A table of bins in the memory of a backend.
#pragma once

#include <cstdint>

#include "common/filter/bins.h"

namespace parloc {

/// Empty, for so many particles.
template <class Space>
class BinArrays {
 public:
  BinArrays(std::size_t particles, typename Space::Queue& queue) : capacity_(bin_capacity(particles)) {
    for (auto* b : {&key_, &weight_}) b->reserve(capacity_);
    parent_.reserve(capacity_);
    for (auto* b : {&slot_of_, &used_}) b->reserve(particles);
    used_count_.reserve(1);
    Space::clear_bins(view(), queue);
  }
  BinTable view() {
    return {.key = key_.data(),
            .weight = weight_.data(),
            .parent = parent_.data(),
            .slot_of = slot_of_.data(),
            .used = used_.data(),
            .used_count = used_count_.data(),
            .capacity = capacity_};
  }

 private:
  std::uint32_t capacity_;
  typename Space::template Array<std::uint64_t> key_, weight_, used_count_;
  typename Space::template Array<std::uint32_t> parent_, slot_of_, used_;
};

}  // namespace parloc
