#include "tools/bench/steps/maps_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "common/error.h"
#include "tools/report/machine/build_info.h"

namespace parloc::tools::bench {
namespace {

namespace fs = std::filesystem;

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// Beside the program, as installed; empty if the program's own path cannot be found out.
fs::path installed_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : (program.parent_path() / kMapsFromProgram).lexically_normal();
}

}  // namespace

std::string find_maps_folder(const std::string& given) {
  if (!given.empty()) {
    if (!is_folder(given)) throw Error(ErrorKind::input, given + ": expected a folder of maps (--maps)");
    return given;
  }
  const fs::path installed = installed_folder();
  for (const fs::path& path : {installed, fs::path(kMapsOfSource)}) {
    if (!path.empty() && is_folder(path)) return path.string();
  }
  throw Error(ErrorKind::input,
              fmt::format("the maps that come with parloc are neither in {} nor in {}: give --maps DIR",
                          installed.string(), kMapsOfSource));
}

}  // namespace parloc::tools::bench
