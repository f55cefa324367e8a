// What times depend on: the machine and the build.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace parloc::tools {

struct Machine {
  std::string cpu;
  int cores = 0;                   ///< That this program may use.
  std::uint64_t memory_bytes = 0;  ///< Of the machine; 0: unknown.
  std::string os;                  ///< Distribution and kernel.
  double load_average =
      0.0;  ///< Of the last minute before the start: other work disturbs times. Negative: unknown.
  std::string gpu_driver;             ///< Empty without one.
  std::vector<std::string> devices;   ///< As `parloc devices` lists them.
  std::vector<std::string> settings;  ///< Variables of the environment that steer threads, as NAME=VALUE.
};

Machine machine_here();

/// The CPU's cores that this program may run on.
int cores_here();

/// "parloc 0.1.0, commit 0123abc", without the latter where it is not known.
std::string version_text();

/// Now, in UTC: "2026-01-31T12:00:00Z".
std::string date_now();

// What is known of this build since it was configured. Written by CMake from build_info.cpp.in.
extern const char* const kVersion;
extern const char* const kCommit;  ///< Empty if the sources were no git checkout. "-dirty": with changes.
extern const char* const kCompiler;
extern const char* const kFlags;
extern const char* const kBuildType;
extern const char* const kCuda;             ///< The compiler of the CUDA backend, or "not in this build".
extern const char* const kMapsOfSource;     ///< Folder of the source tree.
extern const char* const kMapsFromProgram;  ///< From the folder of the installed program.

/// Memory of this program, resident, at most so far; nothing where the system does not say (proc(5), VmHWM).
std::optional<std::size_t> peak_resident_bytes();

}  // namespace parloc::tools
