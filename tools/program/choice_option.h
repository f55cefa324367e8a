// An option of the command line that takes one of the words of a setting.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/settings/setting.h"
#include "tools/program/text_option.h"

namespace parloc::tools {

/// `value_name` stands for the word in the help. CLI11 refuses every other word and names these.
template <class Enum>
CLI::Option* add_choice_option(CLI::App& app, const std::string& name, std::optional<Enum>& target,
                               const std::vector<Choice<Enum>>& choices, const std::string& value_name,
                               const std::string& help) {
  std::vector<std::string> words;
  for (const Choice<Enum>& choice : choices) words.emplace_back(choice.name);
  const auto take = [&target, choices](const std::string& word) {
    for (const Choice<Enum>& choice : choices)
      if (word == choice.name) target = choice.value;
  };
  return app.add_option_function<std::string>(name, take, help)->type_name(value_name)->check(one_of(words));
}

}  // namespace parloc::tools
