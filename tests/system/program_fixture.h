// What the tests of the `parloc` program's commands share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "tests/system/program_runner.h"
#include "tests/unit/expect.h"

namespace parloc::test {

using Json = nlohmann::json;

/// First the one arguments, then the others.
inline Args with(Args args, const Args& more) {
  args.insert(args.end(), more.begin(), more.end());
  return args;
}

/// A command line and how it ends.
struct ProgramCase {
  Args args;
  int code;
  const char* words;  ///< Of its one line on standard error.
};

inline void expect_one_line(const Outcome& o, int code, const std::string& words) {
  EXPECT_EQ(o.code, code) << o.err << o.out;
  expect_parts(o.err, {words});
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}
inline void expect_png(const std::string& path) {
  EXPECT_EQ(content_of(path).substr(1, 3), "PNG") << path;
}
/// Of a command that could not do what was asked: nothing is printed but that line.
inline void expect_error(const Outcome& o, const ProgramCase& c) {
  SCOPED_TRACE(testing::PrintToString(c.args));
  expect_one_line(o, c.code, c.words);
  EXPECT_EQ(o.err.rfind("parloc: ", 0), 0u) << o.err;
  EXPECT_EQ(o.out, "");
}

/// The program with a folder for all cases of a suite: SetUpTestSuite() calls open().
class ProgramSuite : public testing::Test {
 protected:
  static void open(const std::string& folder_name) {
    runner = std::make_unique<ProgramRunner>(PARLOC_PROGRAM, folder_name);
  }
  static void TearDownTestSuite() { runner.reset(); }
  static std::string path(const std::string& name) { return runner->path(name); }
  static Outcome call(const Args& args) { return runner->call(args); }
  /// A call that must succeed.
  static Outcome done(const Args& args) {
    const Outcome o = call(args);
    EXPECT_EQ(o.code, 0) << o.err << testing::PrintToString(args);
    return o;
  }
  /// What it prints as JSON.
  static Json told(const Args& args) { return Json::parse(done(args).out); }
  /// A call that is broken off once it has said these words on standard error, and keeps what it has.
  static Outcome broken_off(const Args& args, const std::string& words, int signal_number = SIGINT) {
    const pid_t child = runner->start(args);
    runner->wait_for(words);
    kill(child, signal_number);
    const Outcome o = runner->finish(child);
    EXPECT_EQ(o.code, 130) << o.err;
    return o;
  }
  static void write(const std::string& name, const std::string& text) { write_file(path(name), text); }
  static std::string read(const std::string& name) { return content_of(path(name)); }
  static Json json_of(const std::string& name) { return Json::parse(read(name)); }

  static inline std::unique_ptr<ProgramRunner> runner;
};

/// A recorded log with map and truth.
inline const Args kLog{"--log",   "maps/logs/malaga_faculty.log.gz", "--map", "maps/malaga_faculty.yaml",
                       "--truth", "maps/logs/malaga_faculty.tum"};

/// A result without what a clock, or the command line, has said.
inline Json lasting(Json json) {
  json.erase("times");
  json.erase("command");
  return json;
}

}  // namespace parloc::test
