#include "common/file/yaml_section.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

#include "common/file/nearest_name.h"

namespace parloc {
namespace {

constexpr std::size_t kLongestText = 1024 * 1024;

std::size_t line_of(const YAML::Mark& mark) {
  return mark.line < 0 ? 0 : static_cast<std::size_t>(mark.line) + 1;
}

Error config_error(const std::string& file, std::size_t line, const std::string& message) {
  return Error(ErrorKind::config, (line > 0 ? fmt::format("{}:{}", file, line) : file) + ": " + message);
}

/// Text from a file, fit for one line of a message.
std::string printable(const std::string& text) {
  constexpr std::size_t longest = 40;
  std::string out = text.substr(0, longest);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text.size() > longest ? out + "..." : out;
}

std::string described(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "nothing";
  if (node.IsMap()) return "a group";
  if (node.IsSequence()) return "a list";
  return fmt::format("'{}'", printable(node.Scalar()));
}

/// Parses a plain (unquoted) scalar completely; false if it is none.
template <class Number>
bool parse_scalar(const YAML::Node& node, Number& value) {
  if (!node.IsScalar() || node.Tag() == "!") return false;
  const std::string& text = node.Scalar();
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc() && end == text.data() + text.size();
}

/// Looks at a text before nodes are made of it: aliases can make a small text large, or refer to themselves.
class StructureCheck : public YAML::EventHandler {
 public:
  explicit StructureCheck(const std::string& file) : file_(file) {}
  void OnDocumentStart(const YAML::Mark& mark) override {
    // Also what ends yaml-cpp's reading of ", 0], x": it finds empty documents there for ever.
    if (++documents_ > 1)
      throw config_error(file_, line_of(mark), "expected one document, found a second one");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { refuse(mark, anchor); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override { refuse(mark, anchor); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string&) override {
    refuse(mark, anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    enter(mark, anchor);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    enter(mark, anchor);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void refuse(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != 0)
      throw config_error(file_, line_of(mark), "anchors and aliases ('&name', '*name') are not allowed");
  }
  void enter(const YAML::Mark& mark, YAML::anchor_t anchor) {
    refuse(mark, anchor);
    constexpr int deepest = 8;
    if (++depth_ > deepest) throw config_error(file_, line_of(mark), "nested too deeply");
  }

  const std::string& file_;
  int depth_ = 0;
  int documents_ = 0;
};

std::string joined(const std::vector<std::string>& names) {
  std::string text = names[0];
  for (std::size_t i = 1; i < names.size(); ++i) text += (i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

}  // namespace

double number_of(const YAML::Node& node, const std::string& file, const std::string& what) {
  double value = 0.0;
  if (!parse_scalar(node, value) || !std::isfinite(value)) {
    throw config_error(file, line_of(node.Mark()),
                       fmt::format("{}: expected a number, got {}", what, described(node)));
  }
  return value;
}

YAML::Node yaml_document(const std::string& text, const std::string& file) {
  if (text.size() > kLongestText) throw config_error(file, 0, "expected at most 1 MiB of YAML");
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    StructureCheck check(file);
    while (parser.HandleNextDocument(check)) {
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw config_error(file, line_of(e.mark), "not valid YAML: " + printable(e.msg));
  }
}

std::string read_small_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw config_error(path, 0, fmt::format("cannot be opened: {}", std::strerror(errno)));
  std::string text(kLongestText + 1, '\0');  // one byte more than allowed tells a file that is too long
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw config_error(path, 0, "cannot be read (is it a folder?)");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

YamlSection::YamlSection(const YAML::Node& node, std::string file, std::string name)
    : file_(std::move(file)), name_(std::move(name)) {
  if (!node.IsDefined()) return;
  line_ = line_of(node.Mark());
  if (!node.IsMap()) {
    throw config_error(file_, line_,
                       fmt::format("{}expected 'key: value' lines, got {}", name_.empty() ? "" : name_ + ": ",
                                   described(node)));
  }
  for (const auto& entry : node) {
    if (!entry.first.IsScalar())
      throw config_error(file_, line_of(entry.first.Mark()), "expected a name as key");
    const std::string key = entry.first.Scalar();
    const auto same = [&](const auto& earlier) { return earlier.first == key; };
    if (std::any_of(entries_.begin(), entries_.end(), same)) {
      throw config_error(file_, line_of(entry.first.Mark()),
                         fmt::format("duplicate key '{}'", printable(full_name(key))));
    }
    entries_.emplace_back(key, entry.second);
  }
}

std::string YamlSection::full_name(const std::string& key) const {
  return name_.empty() ? key : name_ + "." + key;
}

Error YamlSection::error(const std::string& key, const std::string& message) const {
  std::size_t line = line_;
  for (const auto& [name, value] : entries_) {
    if (name == key) line = line_of(value.Mark());
  }
  return config_error(file_, line, full_name(key) + " " + message);
}

YAML::Node YamlSection::node(const std::string& key) {
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.push_back(key);
  for (const auto& [name, value] : entries_) {
    if (name == key) return value;
  }
  return YAML::Node(YAML::NodeType::Undefined);
}

bool YamlSection::has(const std::string& key) {
  return node(key).IsDefined();
}

void YamlSection::require(const std::string& key) {
  if (!has(key)) throw error(key, "is missing");
}

void YamlSection::number(const std::string& key, double& target, double low, double high) {
  if (!has(key)) return;
  const double value = number_of(node(key), file_, full_name(key));
  if (value < low || value > high)
    throw error(key, fmt::format("must be {} to {}, got {}", low, high, value));
  target = value;
}

void YamlSection::integer(const std::string& key, int& target, int low, int high) {
  if (!has(key)) return;
  int value = 0;
  if (!parse_scalar(node(key), value)) {
    throw error(key, fmt::format("must be a whole number, got {}", described(node(key))));
  }
  if (value < low || value > high)
    throw error(key, fmt::format("must be {} to {}, got {}", low, high, value));
  target = value;
}

void YamlSection::seed(const std::string& key, std::uint64_t& target) {
  if (!has(key)) return;
  if (!parse_scalar(node(key), target)) {
    throw error(key, fmt::format("must be a whole number from 0 to 2^64 - 1, got {}", described(node(key))));
  }
}

void YamlSection::text(const std::string& key, std::string& target) {
  if (!has(key)) return;
  if (!node(key).IsScalar() || node(key).Scalar().empty()) {
    throw error(key, fmt::format("must be a text, got {}", described(node(key))));
  }
  target = node(key).Scalar();
}

void YamlSection::boolean(const std::string& key, bool& target) {
  if (!has(key)) return;
  const YAML::Node value = node(key);
  const bool plain = value.IsScalar() && value.Tag() != "!";
  if (!plain || (value.Scalar() != "true" && value.Scalar() != "false"))
    throw error(key, fmt::format("must be true or false, got {}", described(value)));
  target = value.Scalar() == "true";
}

std::size_t YamlSection::choice_index(const std::string& key, const std::vector<std::string>& names) {
  const YAML::Node value = node(key);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (value.IsScalar() && value.Scalar() == names[i]) return i;
  }
  throw error(key, fmt::format("must be {}, got {}", joined(names), described(value)));
}

void YamlSection::numbers(const std::string& key, double* target, std::size_t count) {
  if (!has(key)) return;
  const YAML::Node list = node(key);
  if (!list.IsSequence() || list.size() != count) {
    throw error(key,
                fmt::format("must be a list of {} numbers, got {}", count,
                            list.IsSequence() ? fmt::format("{} values", list.size()) : described(list)));
  }
  for (std::size_t i = 0; i < count; ++i) target[i] = number_of(list[i], file_, full_name(key));
}

YamlSection YamlSection::section(const std::string& key) {
  return YamlSection(node(key), file_, full_name(key));
}

std::vector<YamlSection> YamlSection::sections(const std::string& key) {
  std::vector<YamlSection> list;
  const YAML::Node nodes = node(key);
  if (!nodes.IsDefined()) return list;
  if (!nodes.IsSequence())
    throw error(key, fmt::format("must be a list of groups, got {}", described(nodes)));
  for (std::size_t k = 0; k < nodes.size(); ++k)
    list.emplace_back(nodes[k], file_, fmt::format("{}[{}]", full_name(key), k));
  return list;
}

void YamlSection::finish() const {
  for (const auto& entry : entries_) {
    const std::string& key = entry.first;
    if (std::find(asked_.begin(), asked_.end(), key) != asked_.end()) continue;
    const std::size_t line = line_of(entry.second.Mark());
    const std::string written = printable(full_name(key));
    constexpr std::size_t longest_sensible = 100;  // bounds the work of a hostile key
    if (asked_.empty() || key.size() > longest_sensible) {
      throw config_error(file_, line, fmt::format("unknown key '{}'", written));
    }
    const auto nearest = std::min_element(asked_.begin(), asked_.end(), [&](const auto& a, const auto& b) {
      return edit_distance(key, a) < edit_distance(key, b);
    });
    throw config_error(
        file_, line,
        fmt::format("unknown key '{}'; the nearest valid key is '{}'", written, full_name(*nearest)));
  }
}

}  // namespace parloc
