// An option of the command line that takes one text, or several texts one by one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace parloc::tools {

/// `Text` is std::string, or a vector of them for an option that may come again. `value_name` stands for the
/// value in the help. An empty value, such as an unset variable of a script leaves, is an error rather than
/// the default.
template <class Text>
CLI::Option* add_text_option(CLI::App& app, const std::string& name, Text& target,
                             const std::string& value_name, const std::string& help) {
  const CLI::Validator not_empty(
      [](std::string& text) {
        return text.empty() ? std::string("expected a value, got nothing") : std::string();
      },
      "");
  return app.add_option(name, target, help)->type_name(value_name)->check(not_empty);
}

/// Refuses words other than these, which the message names; the help does not repeat them.
inline CLI::Validator one_of(const std::vector<std::string>& words) {
  return CLI::Validator(CLI::IsMember(words)).description("");
}

}  // namespace parloc::tools
