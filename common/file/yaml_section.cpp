#include "common/file/yaml_section.h"

#include <algorithm>
#include <cstdint>
#include <system_error>

#include "common/file/nearest_name.h"
#include "common/file/text_fields.h"

namespace parloc {

template <class Number>
std::string read_number(YamlKind kind, const std::string& text, Number& target, Number low, Number high,
                        bool above_low) {
  Number value{};
  std::errc status = std::errc::invalid_argument;
  if (kind == YamlKind::plain) status = parse_number(text, value);
  if constexpr (std::is_unsigned_v<Number>) {  // a negative number is one, too
    std::int64_t negative = 0;
    if (kind == YamlKind::plain && status == std::errc::invalid_argument &&
        parse_number(text, negative) != status)
      status = std::errc::result_out_of_range;
  }
  if (status == std::errc::invalid_argument) {
    return fmt::format(": expected {}, got {}", std::is_integral_v<Number> ? "a whole number" : "a number",
                       described(kind, text));
  }
  const bool within = value >= low && value <= high && !(above_low && value == low);  // false for NaN
  if (status != std::errc{} || !within)
    return fmt::format(" must be {}, got {}", limits_text(low, high, above_low), printable(text));
  target = value;
  return {};
}
template std::string read_number(YamlKind, const std::string&, int&, int, int, bool);
template std::string read_number(YamlKind, const std::string&, std::int64_t&, std::int64_t, std::int64_t,
                                 bool);
template std::string read_number(YamlKind, const std::string&, std::uint64_t&, std::uint64_t, std::uint64_t,
                                 bool);
template std::string read_number(YamlKind, const std::string&, double&, double, double, bool);

namespace {

std::string joined(const std::string& section, const std::string& key) {
  return section.empty() ? key : section + "." + key;
}

/// Where a wrong value is: a list or a group may begin below its key.
std::size_t place_of(const YamlNode& node) {
  const bool nested = node.kind == YamlKind::list || node.kind == YamlKind::group;
  return nested || node.key_line == 0 ? node.line : node.key_line;
}

}  // namespace

/// What the sections of a file share.
struct YamlSection::Document {
  struct Asked {
    std::string section, key;
  };
  std::string file;
  ErrorKind error;
  YamlNode root;
  std::vector<Asked> asked;    // also keys that the file lacks
  std::vector<Error> missing;  // required keys

  std::string nearest(const std::string& section, const std::string& key) const;
  void refuse_unknown(const YamlNode& node, const std::string& name) const;
};

std::string YamlSection::Document::nearest(const std::string& section, const std::string& key) const {
  const std::string start = key.substr(0, 100);  // bounds the work of a hostile key
  std::size_t least = static_cast<std::size_t>(-1);
  const Asked* best = nullptr;
  for (const Asked& known : asked) {
    // Doubled, so that another section costs half a letter: it breaks ties, no more.
    const std::size_t distance = 2 * edit_distance(start, known.key) + (known.section == section ? 0 : 1);
    if (distance < least) least = distance, best = &known;
  }
  return best == nullptr ? "" : joined(best->section, best->key);
}

void YamlSection::Document::refuse_unknown(const YamlNode& node, const std::string& name) const {
  for (std::size_t k = 0; k < node.items.size(); ++k) {
    const YamlNode& item = node.items[k];
    const bool has_key = item.key_line > 0;
    const std::string full = has_key ? joined(name, item.key) : fmt::format("{}[{}]", name, k);
    if (has_key && !item.asked)
      throw file_error(error, file, item.key_line, unknown_key_message(full, nearest(name, item.key)));
    refuse_unknown(item, full);
  }
}

YamlSection::YamlSection(const std::string& text, const std::string& file, const YamlRules& rules)
    : document_(
          std::make_shared<Document>(Document{file, rules.error, yaml_tree(text, file, rules), {}, {}})),
      node_(&document_->root) {
  expect_group();
}

YamlSection::YamlSection(std::shared_ptr<Document> document, YamlNode* node, std::string name)
    : document_(std::move(document)), node_(node), name_(std::move(name)) {
  expect_group();
}

void YamlSection::expect_group() {
  if (node_ == nullptr || node_->kind == YamlKind::group) return;
  const bool is_item = node_->key_line == 0 && !name_.empty();  // of a list, which has no empty groups
  if (node_->kind != YamlKind::nothing || is_item) {
    throw error_at(place_of(*node_),
                   fmt::format("{}expected lines of 'key: value', got {}", name_.empty() ? "" : name_ + ": ",
                               described(node_->kind, node_->text)));
  }
  node_ = nullptr;
}

std::string YamlSection::full_name(const std::string& key) const {
  return joined(name_, key);
}

YamlNode* YamlSection::find(const std::string& key) const {
  document_->asked.push_back({name_, key});
  if (node_ == nullptr) return nullptr;
  for (YamlNode& item : node_->items) {
    if (item.key != key) continue;
    item.asked = true;
    return &item;
  }
  return nullptr;
}

std::vector<std::string> YamlSection::keys() const {
  std::vector<std::string> names;
  if (node_ == nullptr) return names;
  for (const YamlNode& item : node_->items) names.push_back(item.key);
  return names;
}

YamlScalar YamlSection::scalar(const std::string& key) const {
  const YamlNode* node = find(key);
  if (node == nullptr) return {};
  const bool is_one = node->kind == YamlKind::plain || node->kind == YamlKind::quoted;
  return {is_one, node->text, described(node->kind, node->text), place_of(*node)};
}

std::size_t YamlSection::line(const std::string& path) const {
  const YamlNode* node = node_;
  std::string rest = path;
  while (node != nullptr && !rest.empty()) {
    const std::size_t dot = std::min(rest.find('.'), rest.size());
    const auto found = std::find_if(node->items.begin(), node->items.end(), [&](const YamlNode& item) {
      return item.key.compare(0, std::string::npos, rest, 0, dot) == 0;
    });
    node = found == node->items.end() ? nullptr : &*found;
    rest.erase(0, dot + 1);
  }
  return node == nullptr ? 0 : node->key_line;
}

void YamlSection::require(const std::string& key) const {
  if (!has(key)) document_->missing.push_back(error(key, "is missing"));
}

void YamlSection::text(const std::string& key, std::string& target, bool may_be_empty) const {
  const YamlNode* node = find(key);
  if (node == nullptr) return;
  const bool scalar = node->kind == YamlKind::plain || node->kind == YamlKind::quoted;
  const bool empty = node->text.empty() && !(may_be_empty && node->kind == YamlKind::quoted);
  if (!scalar || empty) throw mismatch(*node, "a text");
  target = node->text;
}

const std::vector<YamlNode>& YamlSection::list(const std::string& key, const std::string& expected,
                                               std::size_t least, std::size_t most) const {
  static const std::vector<YamlNode> none;
  const YamlNode* node = find(key);
  if (node == nullptr) return none;
  if (node->kind != YamlKind::list) throw mismatch(*node, expected);
  if (node->items.size() < least || node->items.size() > most) {
    throw error_at(place_of(*node), fmt::format("{}: expected {}, got a list of {}", full_name(key), expected,
                                                node->items.size()));
  }
  return node->items;
}

void YamlSection::numbers(const std::string& key, double* target, std::size_t count, double low, double high,
                          const std::string& expected) const {
  for (const YamlNode& item : list(key, expected, count, count))
    *target++ = number_in(item, full_name(key), low, high);
}

YamlSection YamlSection::section(const std::string& key) const {
  return YamlSection(document_, find(key), full_name(key));
}

std::vector<YamlSection> YamlSection::sections(const std::string& key) const {
  std::vector<YamlSection> groups;
  YamlNode* node = find(key);
  if (node == nullptr) return groups;
  if (node->kind != YamlKind::list) throw mismatch(*node, "a list of groups");
  for (std::size_t k = 0; k < node->items.size(); ++k)
    groups.push_back(YamlSection(document_, &node->items[k], fmt::format("{}[{}]", full_name(key), k)));
  return groups;
}

void YamlSection::finish() const {
  document_->refuse_unknown(document_->root, "");
  if (!document_->missing.empty()) throw document_->missing.front();
}

double YamlSection::number_in(const YamlNode& node, const std::string& what, double low, double high) const {
  double value = 0.0;
  expect_number(node, what, read_number(node.kind, node.text, value, low, high));
  return value;
}

void YamlSection::expect_number(const YamlNode& node, const std::string& what,
                                const std::string& wrong) const {
  if (!wrong.empty()) throw error_at(place_of(node), what + wrong);
}

Error YamlSection::error(const std::string& key, const std::string& message) const {
  const std::size_t key_line = line(key);
  const std::size_t group_line = node_ == nullptr ? 0 : node_->line;
  return error_at(key_line > 0 ? key_line : group_line, full_name(key) + " " + message);
}

Error YamlSection::error_at(std::size_t line, const std::string& message) const {
  return file_error(document_->error, document_->file, line, message);
}

Error YamlSection::mismatch(const YamlNode& node, const std::string& expected) const {
  return error_at(place_of(node), fmt::format("{}: expected {}, got {}", full_name(node.key), expected,
                                              described(node.kind, node.text)));
}

}  // namespace parloc
