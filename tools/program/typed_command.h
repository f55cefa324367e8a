// A command line as one types it in a shell, and its words.
#pragma once

#include <string>
#include <vector>

namespace parloc::tools {

/// With quotes where a shell needs them.
std::string typed_command(const std::vector<std::string>& words);
/// The words of what typed_command() gave.
std::vector<std::string> words_of(const std::string& typed);

/// What decides the results: the same command without where they go, how they are told and who computes
/// them. Two runs with the same such command have the same results. Its first word is "parloc".
std::string deciding_command(const std::string& typed);

}  // namespace parloc::tools
