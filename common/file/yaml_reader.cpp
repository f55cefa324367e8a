#include "common/file/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

namespace parloc {
namespace {

std::size_t line_of(const YAML::Mark& mark) {
  return mark.line < 0 ? 0 : static_cast<std::size_t>(mark.line) + 1;
}

bool opens(YamlKind kind) {
  return kind == YamlKind::list || kind == YamlKind::group;
}

/// yaml-cpp's events -> ours: tells keys from values and refuses what no file may have.
class EventFilter : public YAML::EventHandler {
 public:
  EventFilter(const std::string& file, const YamlRules& rules, YamlEvents& events)
      : file_(file), rules_(rules), events_(events) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    // Also what ends yaml-cpp's reading of ", 0], x": it finds empty documents there for ever.
    if (++documents_ > 1) fail(line_of(mark), "expected one document, found a second one");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(mark, "", anchor, YamlKind::nothing, "");
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(line_of(mark), "aliases ('*name') are not allowed");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    const bool quoted = tag == "!" && !rules_.from_elsewhere;
    add(mark, tag, anchor, quoted ? YamlKind::quoted : YamlKind::plain, text);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    add(mark, tag, anchor, YamlKind::list, "");
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    add(mark, tag, anchor, YamlKind::group, "");
  }
  void OnMapEnd() override { end(); }

 private:
  /// A list or a group that is open.
  struct Level {
    bool at_key;  ///< The next event is a key: of a group only.
    bool is_group;
    std::size_t items = 0;                    ///< Of a list, so far.
    std::string key;                          ///< Of a group, the last one.
    std::map<std::string, std::size_t> seen;  ///< Its keys and their lines.
  };

  [[noreturn]] void fail(std::size_t line, const std::string& message) const {
    throw file_error(rules_.error, file_, line, message);
  }
  void refuse_extras(std::size_t line, const std::string& tag, YAML::anchor_t anchor) const {
    if (anchor != 0) fail(line, "anchors ('&name') are not allowed");
    if (!tag.empty() && tag != "?" && tag != "!")  // "?" is a plain scalar, "!" a quoted one
      fail(line, fmt::format("type tags are not allowed, got '{}'", printable(tag)));
  }
  void add(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YamlKind kind,
           const std::string& text) {
    const std::size_t line = line_of(mark);
    if (!rules_.from_elsewhere) refuse_extras(line, tag, anchor);
    if (!levels_.empty()) {
      Level& level = levels_.back();
      if (level.at_key) return add_key(line, kind, text);
      level.at_key = level.is_group;
      ++level.items;
    }
    constexpr std::size_t deepest = 8;
    if (opens(kind) && levels_.size() == deepest) fail(line, "nested too deeply");
    events_.value(kind, text, line);
    if (opens(kind)) levels_.push_back({kind == YamlKind::group, kind == YamlKind::group, 0, {}, {}});
  }
  void add_key(std::size_t line, YamlKind kind, const std::string& text) {
    if (opens(kind) || kind == YamlKind::nothing)
      fail(line, fmt::format("expected a key, got {}{}", described(kind, text),
                             opens(kind) ? ", or a bracket that is not closed" : ""));
    Level& level = levels_.back();
    level.at_key = false;
    level.key = text;
    const auto [first, is_new] = level.seen.try_emplace(text, line);
    if (!is_new)
      fail(line, fmt::format("duplicate key '{}', first on line {}", printable(place()), first->second));
    events_.key(text, line);
  }
  void end() {
    levels_.pop_back();
    events_.end();
  }
  /// "lidars[1].beams"
  std::string place() const {
    std::string name;
    for (const Level& level : levels_) {
      if (level.is_group) {
        name += (name.empty() ? "" : ".") + level.key;
      } else {
        name += fmt::format("[{}]", level.items - 1);
      }
    }
    return name;
  }

  const std::string& file_;
  const YamlRules& rules_;
  YamlEvents& events_;
  std::vector<Level> levels_;
  int documents_ = 0;
};

class TreeBuilder : public YamlEvents {
 public:
  YamlNode root;

  void key(const std::string& name, std::size_t line) override {
    key_ = name;
    key_line_ = line;
  }
  void value(YamlKind kind, const std::string& text, std::size_t line) override {
    YamlNode& node = open_.empty() ? root : open_.back()->items.emplace_back();
    node = {kind, line, text, {}, std::move(key_), std::exchange(key_line_, 0)};
    key_.clear();
    if (opens(kind)) open_.push_back(&node);  // it stays in place: its siblings come after its end
  }
  void end() override { open_.pop_back(); }

 private:
  std::vector<YamlNode*> open_;
  std::string key_;
  std::size_t key_line_ = 0;
};

void refuse_too_long(const std::string& text, const std::string& file, const YamlRules& rules) {
  if (text.size() <= rules.longest) return;
  constexpr std::size_t mebi = 1024 * 1024;
  const bool large = rules.longest >= mebi;
  throw file_error(rules.error, file, 0,
                   fmt::format("expected {} of at most {} {}", rules.what,
                               rules.longest / (large ? mebi : 1024), large ? "MiB" : "KiB"));
}

void refuse_binary(const std::string& text, const std::string& file, const YamlRules& rules) {
  std::size_t line = 1;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool control = byte < 0x20 && c != '\t' && c != '\n' && c != '\r';
    if (control || byte == 0x7f)
      throw file_error(rules.error, file, line, fmt::format("expected text, found the byte 0x{:02x}", byte));
    if (c == '\n') ++line;
  }
}

}  // namespace

void read_yaml(const std::string& text, const std::string& file, const YamlRules& rules, YamlEvents& events) {
  refuse_too_long(text, file, rules);
  if (!rules.from_elsewhere) refuse_binary(text, file, rules);
  EventFilter filter(file, rules, events);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(filter)) {
    }
  } catch (const YAML::Exception& e) {
    throw file_error(rules.error, file, line_of(e.mark), "not valid YAML: " + printable(e.msg));
  }
}

YamlNode yaml_tree(const std::string& text, const std::string& file, const YamlRules& rules) {
  TreeBuilder builder;
  read_yaml(text, file, rules, builder);
  return std::move(builder.root);
}

std::string read_yaml_file(const std::string& path, const YamlRules& rules) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw file_error(rules.error, path, 0, fmt::format("cannot be opened: {}", std::strerror(errno)));
  std::string text(rules.longest + 1, '\0');  // one byte more than allowed tells a file that is too long
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw file_error(rules.error, path, 0, "cannot be read (is it a folder?)");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

std::string described(YamlKind kind, const std::string& text) {
  switch (kind) {
    case YamlKind::nothing:
      return "nothing";
    case YamlKind::list:
      return "a list";
    case YamlKind::group:
      return "a group";
    case YamlKind::quoted:
      return fmt::format("the text \"{}\"", printable(text));
    case YamlKind::plain:
      break;
  }
  return text.empty() ? "nothing" : fmt::format("'{}'", printable(text));
}

}  // namespace parloc
