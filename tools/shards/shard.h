// A part of many trials, for one of many machines.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace parloc::tools::shards {

/// The `number`th of `of` parts, from 1 on. Its trials are every `of`th, so that all parts have as many of
/// every kind.
struct Shard {
  static constexpr std::size_t kMost = 100000;
  std::size_t number = 1, of = 1;

  std::size_t count(std::size_t all) const { return all < number ? 0 : (all - number) / of + 1; }

  std::vector<std::size_t> items(std::size_t all) const {
    std::vector<std::size_t> mine;
    for (std::size_t k = number - 1; k < all; k += of) mine.push_back(k);
    return mine;
  }
};

/// "3/64". Throws Error{usage}.
Shard shard_from_text(const std::string& text);

}  // namespace parloc::tools::shards
