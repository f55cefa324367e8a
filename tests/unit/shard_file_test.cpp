// The file of a shard: what was added stays, whatever the file ends with; and command lines taken apart.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/error.h"
#include "tests/unit/expect.h"
#include "tests/unit/temp_file.h"
#include "tools/program/typed_command.h"
#include "tools/shards/shard_file.h"

namespace parloc::tools::shards {
namespace {

ShardHead head_of(std::size_t number, std::size_t of) {
  return {"parloc evaluate", "1.0", "abc", "particles: 5\n", {{"map", "123"}}, 7, {number, of}};
}

class ShardFileTest : public testing::Test {
 protected:
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("parloc_shard_file_" + std::to_string(getpid()))).string();
  void TearDown() override { std::filesystem::remove_all(folder); }
  std::string bytes() const { return test::content_of(shard_path(folder)); }
  void write(const std::string& bytes) const { std::ofstream(shard_path(folder), std::ios::binary) << bytes; }
};

TEST_F(ShardFileTest, WhatWasAddedIsThereAgain) {
  {
    ShardFile file(folder, head_of(2, 3));
    EXPECT_EQ(file.missing(), (std::vector<std::size_t>{1, 4}));
    file.add(4, 0.5, "four");
    EXPECT_EQ(file.missing(), std::vector<std::size_t>{1});
    error_of([&] { ShardFile(folder, head_of(2, 3)); }, ErrorKind::output);  // one at a time
  }
  ShardFile file(folder, head_of(2, 3));
  EXPECT_EQ(file.missing(), std::vector<std::size_t>{1});
  file.add(1, 0.25, "");
  const ShardContents c = read_shard(shard_path(folder));
  ASSERT_EQ(c.trials.size(), 2u);
  EXPECT_EQ(c.trials[0].item, 4u);
  EXPECT_EQ(bytes().substr(c.trials[0].offset, c.trials[0].size), "four");
  EXPECT_EQ(c.trials[1].took_s, 0.25);
  EXPECT_EQ(c.head.inputs, head_of(2, 3).inputs);
  EXPECT_FALSE(c.damaged);
}

TEST_F(ShardFileTest, WhereverItIsCutOffTheTrialsBeforeAreKept) {
  {
    ShardFile file(folder, head_of(1, 3));
    file.add(0, 0.5, "nought");
    file.add(3, 0.5, "three");
  }
  const std::string whole = bytes();
  const std::vector<StoredTrial> trials = read_shard(shard_path(folder)).trials;
  const std::uint64_t first = trials[1].offset - 24, none = trials[0].offset - 24;  // where they begin
  for (std::size_t size = whole.size() - 1; size >= first; --size) {
    write(whole.substr(0, size));
    const ShardContents c = read_shard(shard_path(folder));
    EXPECT_EQ(c.trials.size(), 1u) << size;
    EXPECT_FALSE(c.damaged) << size;
    ShardFile file(folder, head_of(1, 3));
    EXPECT_EQ(file.missing(), (std::vector<std::size_t>{3, 6}));
    EXPECT_EQ(bytes().size(), first);
  }
  // Before that it is no file of a shard.
  for (std::size_t size = 1; size < none; size += 7) {
    write(whole.substr(0, size));
    error_of([&] { read_shard(shard_path(folder)); }, ErrorKind::input);
  }
}

TEST_F(ShardFileTest, AChangedBitIsDamageAndNoTrial) {
  {
    ShardFile file(folder, head_of(1, 3));
    file.add(0, 0.5, "nought");
    file.add(3, 0.5, "three");
  }
  const std::string whole = bytes();
  const std::uint64_t first = read_shard(shard_path(folder)).trials[0].offset - 24;
  for (std::size_t at = first; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 4);
    write(changed);
    EXPECT_LT(read_shard(shard_path(folder)).trials.size(), 2u) << at;
  }
}

TEST(ShardHead, TheFirstDifferenceIsNamed) {
  const ShardHead a = head_of(1, 3);
  EXPECT_EQ(difference(a, "a", head_of(2, 3), "b"), "");
  const auto told = [&](auto change) {
    ShardHead b = head_of(2, 3);
    change(b);
    return difference(a, "a", b, "b");
  };
  expect_parts(told([](ShardHead& b) { b.command = "parloc compare"; }), {"b is of the command", "compare"});
  expect_parts(told([](ShardHead& b) { b.commit = "def"; }), {"b is of parloc '1.0 def', a of '1.0 abc'"});
  expect_parts(told([](ShardHead& b) { b.settings = ""; }), {"other settings"});
  expect_parts(told([](ShardHead& b) { b.inputs[0].second = "4"; }), {"another map"});
  expect_parts(told([](ShardHead& b) { b.inputs.push_back({"x", "4"}); }), {"other files"});
  expect_parts(told([](ShardHead& b) { b.items = 8; }), {"trials '8'"});
  expect_parts(told([](ShardHead& b) { b.shard.of = 4; }), {"number of shards '4'"});
  EXPECT_EQ(difference(a, "a", head_from_text(text_of(a), "f"), "b"), "");
  for (const char* text : {"", "{}", "[]", "{\"command\": 3}"})
    error_of([&] { head_from_text(text, "f"); }, ErrorKind::input);
}

TEST(TypedCommand, WordsComeBack) {
  const std::vector<std::string> words{"parloc", "a b", "it's", "", "--x=1,2", "'", "\\", "ü"};
  EXPECT_EQ(words_of(typed_command(words)), words);
  EXPECT_EQ(
      deciding_command("./build/parloc evaluate --out 'my folder' --jobs=3 --trials 5 --shard 1/3 --json"),
      "parloc evaluate --trials 5");
}

}  // namespace
}  // namespace parloc::tools::shards
