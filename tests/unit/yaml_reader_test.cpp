// The one reader of YAML: what it hands on, and what it refuses in every file, at which line.
#include "common/file/yaml_reader.h"

#include <gtest/gtest.h>

#include "common/file/yaml_section.h"
#include "tests/unit/expect.h"

namespace parloc {
namespace {

constexpr YamlRules kOwn{"a test", 1024 * 1024, ErrorKind::config};
constexpr YamlRules kElsewhere{"a test", 1024 * 1024, ErrorKind::input, true};

std::string error_of(const std::string& text, const YamlRules& rules) {
  return parloc::error_of([&] { yaml_tree(text, "f", rules); }, rules.error);
}

TEST(YamlReader, EveryValueHasItsLine) {
  const YamlNode root = yaml_tree("# c\na: 'x'\nb:\n  - 1\n  - {c: ~}\n", "f", kOwn);
  ASSERT_EQ(root.items.size(), 2u);
  EXPECT_EQ(root.items[0].key, "a");
  EXPECT_EQ(root.items[0].key_line, 2u);
  EXPECT_EQ(root.items[0].kind, YamlKind::quoted);
  const YamlNode& list = root.items[1];
  EXPECT_EQ(list.key_line, 3u);
  EXPECT_EQ(list.line, 4u);
  EXPECT_EQ(list.items[0].text, "1");
  EXPECT_EQ(list.items[1].line, 5u);
  EXPECT_EQ(list.items[1].items[0].kind, YamlKind::nothing);
  EXPECT_EQ(yaml_tree("a: 'x'\n", "f", kElsewhere).items[0].kind, YamlKind::plain);
}

TEST(YamlReader, RefusesWhatNoFileMayHave) {
  for (const YamlRules& rules : {kOwn, kElsewhere}) {
    EXPECT_EQ(error_of("a: 1\n---\nb: 2\n", rules), "f:2: expected one document, found a second one");
    EXPECT_EQ(error_of("a: 1\nb: [{c: 1, d: 2, c: 3}]\n", rules),
              "f:2: duplicate key 'b[0].c', first on line 2");
    EXPECT_EQ(error_of("a:\n b:\n  - [[[[[[[1]]]]]]]\n", rules), "f:3: nested too deeply");
    EXPECT_EQ(error_of("a: 1\n: 2\n", rules), "f:2: expected a key, got nothing");
    EXPECT_EQ(error_of("a: 1\n\tb: 2\n", rules).substr(0, 20), "f:2: not valid YAML:");
    EXPECT_EQ(error_of(std::string(1024 * 1024 + 1, ' '), rules), "f: expected a test of at most 1 MiB");
    for (const char* deep : {"[", "{a: ", "- ", "? ", "a: ["}) {
      std::string text;
      while (text.size() < 200'000) text += deep;
      EXPECT_EQ(error_of(text, rules).substr(0, 4), "f:1:") << deep;
    }
  }
  EXPECT_EQ(error_of("a: &x 1\n", kOwn), "f:1: anchors ('&name') are not allowed");
  EXPECT_EQ(error_of("a: &x 1\nb: [*x, *x]\n", kElsewhere), "f:2: aliases ('*name') are not allowed");
  EXPECT_EQ(error_of("a: !!int 1\n", kOwn), "f:1: type tags are not allowed, got 'tag:yaml.org,2002:int'");
  EXPECT_EQ(error_of("a: 1\nb: \x07\n", kOwn), "f:2: expected text, found the byte 0x07");
  EXPECT_NO_THROW(yaml_tree("a: &x !!int 1\n", "f", kElsewhere));
}

// Looking for duplicates and for the nearest key must not grow with the square of the keys.
TEST(YamlSection, ManyKeysAreOneError) {
  std::string text;
  for (int k = 0; text.size() < kOwn.longest - 20; ++k) text += std::to_string(k) + ":\n";
  const YamlSection top(text, "f", kOwn);
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(top.has("key" + std::to_string(k)));
  EXPECT_THROW(top.finish(), Error);
}

TEST(YamlSection, UnknownKeysComeBeforeMissingOnes) {
  const YamlSection top("group:\n  spede: 1\n", "f", kOwn);
  top.require("speed");
  double value = 0.0;
  top.section("group").number("length", value, 0, 1);
  EXPECT_EQ(parloc::error_of([&] { top.finish(); }, ErrorKind::config),
            "f:2: unknown key 'group.spede'; the nearest valid key is 'speed'");
}

}  // namespace
}  // namespace parloc
