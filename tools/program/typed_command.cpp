#include "tools/program/typed_command.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace parloc::tools {
namespace {

/// Options that decide nothing: with a value, and without.
constexpr std::array kWithValue{"--out", "--jobs", "--shard", "--merged"};
constexpr std::array kAlone{"--quiet", "--json"};

bool is_plain(const std::string& word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("-_./,:=+@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
}

}  // namespace

std::string typed_command(const std::vector<std::string>& words) {
  std::string typed;
  for (const std::string& word : words) {
    if (!typed.empty()) typed += ' ';
    if (is_plain(word)) {
      typed += word;
      continue;
    }
    typed += '\'';
    for (const char c : word) typed += c == '\'' ? std::string("'\\''") : std::string(1, c);
    typed += '\'';
  }
  return typed;
}

std::vector<std::string> words_of(const std::string& typed) {
  std::vector<std::string> words;
  bool quoted = false, in_word = false;
  for (std::size_t k = 0; k < typed.size(); ++k) {
    const char c = typed[k];
    if (c == ' ' && !quoted) {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (c == '\'')
      quoted = !quoted;
    else if (c == '\\' && !quoted && k + 1 < typed.size())
      words.back() += typed[++k];
    else
      words.back() += c;
  }
  return words;
}

std::string deciding_command(const std::string& typed) {
  std::vector<std::string> kept;
  const std::vector<std::string> words = words_of(typed);
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    const auto is = [&](const char* option) { return word == option; };
    const auto begins = [&](const char* option) { return word.rfind(std::string(option) + "=", 0) == 0; };
    if (std::any_of(kAlone.begin(), kAlone.end(), is)) continue;
    if (std::any_of(kWithValue.begin(), kWithValue.end(), begins)) continue;
    if (std::any_of(kWithValue.begin(), kWithValue.end(), is)) {
      ++k;
      continue;
    }
    kept.push_back(k == 0 ? "parloc" : word);
  }
  return typed_command(kept);
}

}  // namespace parloc::tools
