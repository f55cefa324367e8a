// Commands that the Python package executes: which Python, with which words, and what if there is none.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/system/program_fixture.h"

namespace parloc::test {
namespace {

class PythonCommand : public ProgramSuite {
 protected:
  static void SetUpTestSuite() { open("parloc_python_command_test"); }

  /// With programs from that folder alone.
  static Outcome call_with(const std::string& folder, const Args& args) {
    return runner->finish(runner->start(args, "", [&] {
      setenv("PATH", path(folder).c_str(), 1);
      setenv("PYTHONPATH", "/nowhere", 1);
    }));
  }
  static void write_python(const std::string& folder, const std::string& script) {
    std::filesystem::create_directories(path(folder));
    write(folder + "/python3", "#!/bin/sh\n" + script);
    std::filesystem::permissions(path(folder + "/python3"), std::filesystem::perms::owner_all);
  }
};

TEST_F(PythonCommand, TheWordsArePassedOnWithTheProgram) {
  write_python("good",
               "[ \"$1\" = -c ] && exit 0\n"  // whether it has the package
               "for word in \"$@\"; do echo \"<$word>\"; done\n"
               "echo \"$PARLOC_PROGRAM\"\n"
               "exit 7\n");
  const Outcome o = call_with("good", {"sweep", "S.yaml", "--help", "it's", "", "run"});
  EXPECT_EQ(o.code, 7);
  EXPECT_EQ(o.out, "<-m>\n<parloc.sweeps>\n<S.yaml>\n<--help>\n<it's>\n<>\n<run>\n" +
                       std::filesystem::canonical(PARLOC_PROGRAM).string() + "\n");
}

TEST_F(PythonCommand, WithoutThePackageOneLineSaysWhatToInstall) {
  write_python("bare", "exit 1\n");
  for (const char* folder : {"bare", "none"})
    expect_error(call_with(folder, {"sweep", "S.yaml"}), {{"sweep"}, 6, "pip install ."});
}

}  // namespace
}  // namespace parloc::test
