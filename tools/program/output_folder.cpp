#include "tools/program/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/error.h"

namespace parloc::tools {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::output, fmt::format("{}: cannot be written: {}", path, reason));
}

/// The folders of `path` that do not exist yet, outermost first.
std::vector<std::string> missing_folders(const fs::path& path) {
  std::vector<std::string> missing;
  std::error_code error;
  for (fs::path p = path; !p.empty() && !fs::exists(p, error) && !error; p = p.parent_path()) {
    missing.push_back(p.string());
    if (p == p.parent_path()) break;
  }
  std::reverse(missing.begin(), missing.end());
  return missing;
}

constexpr const char* kStaging = ".parloc-";

/// A folder that is locked as long as its run lives; -1 if another run has the lock.
int lock_folder(const std::string& folder) {
  const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  if (file >= 0) close(file);
  return -1;
}

/// The staging folders of runs that were killed.
void remove_left_over(const std::string& folder) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with(kStaging)) found.push_back(entry.path());
  for (const fs::path& path : found) {
    const int lock = lock_folder(path.string());
    if (lock < 0) continue;
    fs::remove_all(path, ignored);
    close(lock);
  }
}

}  // namespace

OutputFolder::OutputFolder(const std::string& folder, std::vector<std::string> files)
    : folder_(folder), files_(std::move(files)) {
  while (folder_.size() > 1 && folder_.back() == '/') folder_.pop_back();
  created_ = missing_folders(folder_);
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) fail(folder_, error.message());
  for (const std::string& file : files_) {
    if (fs::is_directory(final_path(file), error))
      fail(final_path(file), "a folder of that name is in the way");
  }
  remove_left_over(folder_);
  make_staging();
}

/// Another run that starts at this moment may take the new folder for one that was left over, until it is
/// locked: then there is another one.
void OutputFolder::make_staging() {
  constexpr int kTries = 10;  // more than any bad luck: the file system has no locks, and goes without
  for (int k = 0; k < kTries; ++k) {
    staging_ = folder_ + "/" + kStaging + "XXXXXX";
    if (mkdtemp(staging_.data()) == nullptr) fail(folder_, std::strerror(errno));
    lock_ = lock_folder(staging_);
    std::error_code ignored;
    if (lock_ >= 0 && fs::exists(staging_, ignored)) return;
    if (k + 1 == kTries) return;
    fs::remove(staging_, ignored);
    if (lock_ >= 0) close(lock_);
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  if (lock_ >= 0) close(lock_);
  for (auto folder = created_.rbegin(); folder != created_.rend(); ++folder) {
    if (!fs::is_empty(*folder, ignored) || ignored) break;
    fs::remove(*folder, ignored);
  }
}

void OutputFolder::publish(const std::vector<std::string>& keep) {
  for (const std::string& file : files_) {
    std::error_code error;
    if (fs::exists(staged(file), error)) {
      fs::rename(staged(file), final_path(file), error);
    } else if (std::find(keep.begin(), keep.end(), file) == keep.end()) {
      fs::remove(final_path(file), error);
    }
    if (error) fail(final_path(file), error.message());
  }
}

}  // namespace parloc::tools
