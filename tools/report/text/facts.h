// What is said line by line: a name and a value.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace parloc::tools {

/// Both are plain text: the writers escape them.
struct Fact {
  std::string key, value;
};
using Facts = std::vector<Fact>;

/// A titled table of facts: configuration, beams used and rejected, map, digest.
struct FactTable {
  std::string title;
  Facts facts;
};

/// A line for each, the values below each other from column `width` on.
std::string aligned_text(const Facts& facts, std::size_t width);
std::string markdown_list(const Facts& facts);
/// A <table> of class `kind` with a row for each.
std::string facts_table(const Facts& facts, const char* kind = "");

}  // namespace parloc::tools
