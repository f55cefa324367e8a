#include "tools/output_folder.h"

#include <fmt/format.h>
#include <stdlib.h>

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
  staging_ = folder_ + "/.parloc-XXXXXX";
  if (mkdtemp(staging_.data()) == nullptr) fail(folder_, std::strerror(errno));
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
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
