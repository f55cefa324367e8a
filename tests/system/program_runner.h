// Runs the `parloc` program as a shell would, and catches what it prints.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "tests/unit/temp_file.h"

namespace parloc::test {

using Args = std::vector<std::string>;

inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// Name -> content of every file below a folder.
inline std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    files[entry.path().string()] = entry.is_regular_file() ? content_of(entry.path()) : "";
  }
  return files;
}

struct Outcome {
  int code = -1;  ///< -1: killed by a signal.
  std::string out, err;
};

/// A program, with a folder of its own for files, which is removed at the end.
class ProgramRunner {
 public:
  ProgramRunner(std::string program, const std::string& folder_name)
      : program_(std::move(program)),
        folder_(std::filesystem::temp_directory_path() / (folder_name + "_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~ProgramRunner() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ProgramRunner(const ProgramRunner&) = delete;
  ProgramRunner& operator=(const ProgramRunner&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Starts the program with its output going to files. `prepare` runs in the new process, before it.
  pid_t start(const Args& args, const std::string& stdout_path = "",
              const std::function<void()>& prepare = {}) const {
    std::filesystem::remove(path("stderr"));  // so that nobody reads an earlier one's
    const pid_t child = fork();
    if (child != 0) return child;
    signal(SIGINT, SIG_DFL);
    const std::string out_path = stdout_path.empty() ? path("stdout") : stdout_path;
    const int out = open(out_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int err = open(path("stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    std::vector<char*> argv{const_cast<char*>(program_.c_str())};
    for (const std::string& arg : args) argv.push_back(const_cast<char*>(arg.c_str()));
    argv.push_back(nullptr);
    if (prepare) prepare();
    execv(program_.c_str(), argv.data());
    _exit(127);
  }
  Outcome finish(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(path("stdout")),
            content_of(path("stderr"))};
  }
  Outcome call(const Args& args) const { return finish(start(args)); }

  /// Waits until the running program has printed `part` on standard error, a minute at most.
  void wait_for(const std::string& part) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (content_of(path("stderr")).find(part) == std::string::npos &&
           std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

 private:
  std::string program_;
  std::filesystem::path folder_;
};

}  // namespace parloc::test
