// The valid name that a misspelt one was probably meant to be.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.h"

namespace parloc {

/// Levenshtein distance: insertions, deletions and replacements of one character. O(|a| |b|) time, O(|b|)
/// memory.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

/// The one of `names` (not empty) that `written` is nearest to; looks at its first 100 characters, which
/// bounds the work of a hostile name.
template <class Names>
std::string_view nearest_name(std::string_view written, const Names& names) {
  const std::string_view start = written.substr(0, 100);
  return *std::min_element(names.begin(), names.end(), [&](std::string_view a, std::string_view b) {
    return edit_distance(start, a) < edit_distance(start, b);
  });
}

inline std::string unknown_key_message(std::string_view written, std::string_view nearest) {
  return "unknown key '" + printable(written) + "'; the nearest valid key is '" + std::string(nearest) + "'";
}

}  // namespace parloc
