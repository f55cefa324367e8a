#include "tools/program/parse_number.h"

#include <fmt/format.h>

#include <cstddef>
#include <vector>

#include "common/error.h"

namespace parloc::tools {
namespace {

/// "a,b,c" as exactly `count` numbers.
std::vector<double> parse_list(const char* option, const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string& word : split_at_commas(text))
    numbers.push_back(parse_number(option, word, -1e9, 1e9));
  if (numbers.size() != count || numbers.back() < 0.0)
    throw Error(ErrorKind::usage,
                fmt::format("{}: expected {} numbers, the last not negative, got '{}'", option, count, text));
  return numbers;
}

}  // namespace

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) c == ',' ? void(parts.emplace_back()) : parts.back().push_back(c);
  return parts;
}

SearchPrior parse_search_prior(const std::string& near, const std::string& heading) {
  SearchPrior prior;
  if (!near.empty()) {
    const std::vector<double> v = parse_list("--near", near, 3);
    prior.region = {{v[0], v[1], v[2]}};
  }
  if (!heading.empty()) {
    const std::vector<double> v = parse_list("--heading", heading, 2);
    prior.heading = {{v[0], v[1]}};
  }
  return prior;
}

}  // namespace parloc::tools
