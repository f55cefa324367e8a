// Reads YAML strictly, as events or as a small tree: every key and value has its line, and whatever could
// make a text mean more than it says is refused where it stands. The only file that knows yaml-cpp is
// yaml_reader.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/error.h"

namespace parloc {

/// What kind of file is read.
struct YamlRules {
  const char* what;             ///< "a configuration"; for messages.
  std::size_t longest;          ///< [bytes]
  ErrorKind error;              ///< Of every error but those of the caller's own.
  bool from_elsewhere = false;  ///< Other programs write such files: anchors, type tags, control characters
                                ///< and quotes about numbers are read over.
};

enum class YamlKind { nothing, plain, quoted, list, group };

/// Takes what a text says, in its order.
class YamlEvents {
 public:
  virtual ~YamlEvents() = default;
  /// A key of the innermost group that is open, where it occurs for the first time. Its value comes next.
  virtual void key(const std::string& name, std::size_t line) = 0;
  /// `text` is empty unless the kind is plain or quoted. A list or a group stays open until its end().
  virtual void value(YamlKind kind, const std::string& text, std::size_t line) = 0;
  virtual void end() = 0;
};

/// Sends `text` to `events`; a text of comments sends none. `file` is used in messages only. Throws
/// Error{rules.error} with file:line for text that is too long or not YAML, an alias, a second document, a
/// duplicate key, a key that is no text, nesting deeper than 8, and unless it is from elsewhere for an
/// anchor, a type tag or a control character. Time and memory are linear in the text, keys of one group
/// apart.
void read_yaml(const std::string& text, const std::string& file, const YamlRules& rules, YamlEvents& events);

/// A value, and the key it belongs to.
struct YamlNode {
  YamlKind kind = YamlKind::nothing;
  std::size_t line = 0;
  std::string text;             ///< Of kinds plain and quoted.
  std::vector<YamlNode> items;  ///< Of a list or a group.
  std::string key;
  std::size_t key_line = 0;  ///< 0: it has no key.
  bool asked = false;        ///< For common/file/yaml_section.h.
};

/// The same as a tree, for files that are small: it takes about 100 times the memory of the text.
YamlNode yaml_tree(const std::string& text, const std::string& file, const YamlRules& rules);

/// The text of a file, which may be a pipe, but at most one byte more than the rules allow. Throws
/// Error{rules.error} if it cannot be read.
std::string read_yaml_file(const std::string& path, const YamlRules& rules);

/// "nothing", "a list", "a group", "'0.5'" or "the text \"0.5\"".
std::string described(YamlKind kind, const std::string& text);

}  // namespace parloc
