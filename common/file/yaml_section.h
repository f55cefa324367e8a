// A group of keys of a YAML file, read strictly: whatever nobody asked for is an error with its nearest valid
// name. Private to readers of small hand-written files (scenarios, paths); it shows yaml-cpp.
#pragma once

#include <yaml-cpp/node/node.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"

namespace parloc {

/// One mapping. Ask for every key it may have, then call finish(). Absent keys leave their target alone.
/// All functions throw Error{config} with file:line for a wrong type or a value outside its limits (both
/// included).
class YamlSection {
 public:
  /// `name` is the section's place, "" at the top; `node` is a mapping, or undefined for a section left out.
  YamlSection(const YAML::Node& node, std::string file, std::string name);

  bool has(const std::string& key);
  void require(const std::string& key);
  void number(const std::string& key, double& target, double low, double high);
  void integer(const std::string& key, int& target, int low, int high);
  void seed(const std::string& key, std::uint64_t& target);
  void text(const std::string& key, std::string& target);
  void boolean(const std::string& key, bool& target);
  /// One of the names; the target becomes its value.
  template <class Enum>
  void choice(const std::string& key, Enum& target, const std::vector<std::pair<const char*, Enum>>& names) {
    if (!has(key)) return;
    std::vector<std::string> allowed;
    for (const auto& [name, value] : names) allowed.emplace_back(name);
    target = names[choice_index(key, allowed)].second;
  }
  /// A list of exactly `count` finite numbers.
  void numbers(const std::string& key, double* target, std::size_t count);
  YamlSection section(const std::string& key);
  /// A list of mappings, named key[0], key[1], ...; empty if the key is absent.
  std::vector<YamlSection> sections(const std::string& key);
  /// The value as it stands: an undefined node if the key is absent.
  YAML::Node node(const std::string& key);

  /// Throws if the file has a key that was never asked for, naming the nearest one that was.
  void finish() const;

  /// An error at the key's line ("file:line: section.key message").
  Error error(const std::string& key, const std::string& message) const;

 private:
  std::size_t choice_index(const std::string& key, const std::vector<std::string>& names);
  std::string full_name(const std::string& key) const;

  std::string file_;
  std::string name_;
  std::size_t line_ = 0;  // 0: the section was left out
  std::vector<std::pair<std::string, YAML::Node>> entries_;
  std::vector<std::string> asked_;
};

/// The number that a scalar holds; throws Error{config} with "file:line: what: expected a number, got ...".
double number_of(const YAML::Node& node, const std::string& file, const std::string& what);

/// The one document of a YAML text of at most 1 MiB. Throws Error{config} with file:line.
YAML::Node yaml_document(const std::string& text, const std::string& file);

/// The text of a small file. Throws Error{config} if it cannot be read.
std::string read_small_file(const std::string& path);

}  // namespace parloc
