#include "common/config/nav2_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "common/config/nav2_parameters.h"
#include "common/error.h"

namespace parloc {
namespace {

constexpr const char* kParameters = "ros__parameters";

/// The parameters of one node, as a file has them.
struct Node {
  std::string name;  // "/robot1/amcl"
  std::size_t line;
  std::vector<Nav2Value> values;

  std::string last_name() const { return name.substr(name.rfind('/') + 1); }
};

void collect_values(const YamlNode& group, const std::string& prefix, std::vector<Nav2Value>& values) {
  for (const YamlNode& item : group.items) {
    const std::string name = prefix + item.key;
    if (item.kind == YamlKind::group) {
      collect_values(item, name + ".", values);
    } else {
      values.push_back({name, item.kind, item.text, item.key_line});
    }
  }
}

/// Names of nodes may stand in one key ("/robot1/amcl") or in a group each.
void collect_nodes(const YamlNode& group, const std::string& name, std::vector<Node>& nodes) {
  for (const YamlNode& item : group.items) {
    if (item.key == kParameters) {
      nodes.push_back({name.empty() ? "/" : name, item.key_line, {}});
      collect_values(item, "", nodes.back().values);
    } else if (item.kind == YamlKind::group) {
      const std::string key = item.key.substr(item.key.rfind("//") == 0 ? 1 : 0);
      collect_nodes(item, name + (key.starts_with('/') ? "" : "/") + key, nodes);
    }
  }
}

std::string names_of(const std::vector<Node>& nodes) {
  constexpr std::size_t most = 6;
  std::vector<std::string> names;
  for (const Node& node : nodes)
    if (names.size() < most) names.push_back(printable(node.name));
  return fmt::format("{}{}", fmt::join(names, ", "), nodes.size() > most ? ", ..." : "");
}

bool has_parameter_of_amcl(const Node& node) {
  return std::any_of(node.values.begin(), node.values.end(), [](const Nav2Value& value) {
    const Nav2Parameter* known = nav2_parameter(value.name);
    return known != nullptr && known->fate != Nav2Fate::none;
  });
}

/// Those of `more` over those of the same name.
void merge(std::vector<Nav2Value>& values, const std::vector<Nav2Value>& more) {
  for (const Nav2Value& value : more) {
    std::erase_if(values, [&](const Nav2Value& other) { return other.name == value.name; });
    values.push_back(value);
  }
}

}  // namespace

std::optional<Nav2File> nav2_file(const std::string& text, const std::string& name) {
  if (text.find(kParameters) == std::string::npos) return std::nullopt;
  const YamlNode root =
      yaml_tree(text, name, {"a parameter file of ROS 2", kLongestNav2File, ErrorKind::config});
  std::vector<Node> nodes;
  collect_nodes(root, "", nodes);
  if (nodes.empty()) return std::nullopt;
  std::vector<Node> amcls, for_all;
  for (const Node& node : nodes) {
    if (node.last_name() == "amcl") amcls.push_back(node);
    if (node.last_name() == "**" || node.last_name() == "*") for_all.push_back(node);
  }
  if (amcls.size() > 1)
    throw file_error(ErrorKind::config, name, amcls[1].line,
                     fmt::format("expected the parameters of one amcl, found those of {}", names_of(amcls)));
  Nav2File file;
  for (const Node& node : for_all) merge(file.values, node.values);
  if (amcls.empty()) {
    if (std::none_of(for_all.begin(), for_all.end(), has_parameter_of_amcl))
      throw file_error(
          ErrorKind::config, name, nodes.front().line,
          fmt::format("expected 'amcl:' with {}, found those of {}", kParameters, names_of(nodes)));
    file.node = for_all.front().name;
    return file;
  }
  file.node = amcls.front().name;
  merge(file.values, amcls.front().values);
  return file;
}

}  // namespace parloc
