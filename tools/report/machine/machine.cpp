#include "tools/report/machine/machine.h"

#include <fmt/format.h>
#include <omp.h>
#include <sys/sysinfo.h>
#include <sys/utsname.h>

#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string_view>

#include "common/file/processor_name.h"
#include "common/filter/filter_backend.h"

namespace parloc::tools {
namespace {

/// What stands behind the separator in the first line that begins with `key`; empty if there is none.
std::string line_of(const std::string& path, std::string_view key, char separator) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t at = line.find(separator);
    if (line.rfind(key, 0) != 0 || at == std::string::npos) continue;
    std::string value = line.substr(at + 1);
    value.erase(0, value.find_first_not_of(" \t\""));
    value.erase(value.find_last_not_of(" \t\"") + 1);
    return value;
  }
  return "";
}

std::string operating_system() {
  utsname kernel{};
  std::string text = line_of("/etc/os-release", "PRETTY_NAME", '=');
  if (uname(&kernel) == 0) {
    text +=
        fmt::format("{}{} {} {}", text.empty() ? "" : ", ", kernel.sysname, kernel.release, kernel.machine);
  }
  return text;
}

std::string nvidia_driver() {
  std::ifstream file("/proc/driver/nvidia/version");
  std::string line;
  std::getline(file, line);
  return line;
}

std::vector<std::string> thread_settings() {
  std::vector<std::string> settings;
  for (const char* name :
       {"OMP_NUM_THREADS", "OMP_THREAD_LIMIT", "OMP_PROC_BIND", "OMP_PLACES", "OMP_DYNAMIC",
        "OMP_WAIT_POLICY", "GOMP_CPU_AFFINITY", "GOMP_SPINCOUNT", "CUDA_VISIBLE_DEVICES"}) {
    const char* value = std::getenv(name);
    if (value != nullptr) settings.push_back(fmt::format("{}={}", name, value));
  }
  return settings;
}

}  // namespace

int cores_here() {
  return omp_get_num_procs();
}

Machine machine_here() {
  Machine m;
  m.cpu = processor_name();
  m.cores = cores_here();
  struct sysinfo info {};
  if (sysinfo(&info) == 0) m.memory_bytes = std::uint64_t{info.totalram} * info.mem_unit;
  m.os = operating_system();
  double load[1] = {};
  m.load_average = getloadavg(load, 1) == 1 ? load[0] : -1.0;
  m.gpu_driver = nvidia_driver();
  m.devices = describe_devices();
  m.settings = thread_settings();
  return m;
}

std::optional<std::size_t> peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::size_t kib = 0;
  while (status >> word)
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
  return std::nullopt;
}

std::string version_text() {
  return fmt::format("parloc {}{}", kVersion, kCommit[0] == '\0' ? "" : fmt::format(", commit {}", kCommit));
}

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

}  // namespace parloc::tools
