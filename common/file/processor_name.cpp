#include "common/file/processor_name.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

namespace parloc {
namespace {

/// Implementer and part, as /proc/cpuinfo writes them.
const std::map<std::string, std::string>& arm_cores() {
  static const std::map<std::string, std::string> names = {
      {"0x41 0xd03", "Cortex-A53"},   {"0x41 0xd04", "Cortex-A35"},   {"0x41 0xd05", "Cortex-A55"},
      {"0x41 0xd07", "Cortex-A57"},   {"0x41 0xd08", "Cortex-A72"},   {"0x41 0xd09", "Cortex-A73"},
      {"0x41 0xd0a", "Cortex-A75"},   {"0x41 0xd0b", "Cortex-A76"},   {"0x41 0xd0c", "Neoverse-N1"},
      {"0x41 0xd0d", "Cortex-A77"},   {"0x41 0xd40", "Neoverse-V1"},  {"0x41 0xd41", "Cortex-A78"},
      {"0x41 0xd42", "Cortex-A78AE"}, {"0x41 0xd44", "Cortex-X1"},    {"0x41 0xd46", "Cortex-A510"},
      {"0x41 0xd47", "Cortex-A710"},  {"0x41 0xd48", "Cortex-X2"},    {"0x41 0xd49", "Neoverse-N2"},
      {"0x41 0xd4d", "Cortex-A715"},  {"0x41 0xd4e", "Cortex-X3"},    {"0x41 0xd4f", "Neoverse-V2"},
      {"0x41 0xd80", "Cortex-A520"},  {"0x41 0xd81", "Cortex-A720"},  {"0x41 0xd82", "Cortex-X4"},
      {"0x46 0x001", "A64FX"},        {"0x48 0xd01", "TaiShan-v110"}, {"0x4e 0x003", "Denver 2"},
      {"0x4e 0x004", "Carmel"},       {"0xc0 0xac3", "AmpereOne"},    {"0xc0 0xac4", "AmpereOne"},
  };
  return names;
}

std::string arm_core(const std::string& implementer, const std::string& part) {
  const auto known = arm_cores().find(implementer + " " + part);
  return known != arm_cores().end() ? known->second : "ARM implementer " + implementer + " part " + part;
}

/// If the line is "key  : value", its value.
bool has_value(const std::string& line, const std::string& key, std::string& value) {
  const std::size_t colon = line.find(':');
  if (line.rfind(key, 0) != 0 || colon == std::string::npos) return false;
  const std::size_t from = line.find_first_not_of(" \t", colon + 1);
  value = from == std::string::npos ? "" : line.substr(from);
  return true;
}

}  // namespace

std::string processor_name(std::istream& cpuinfo, const std::string& board) {
  std::vector<std::string> cores;  // each kind once
  std::string model, implementer, part;
  for (std::string line; std::getline(cpuinfo, line);) {
    if (model.empty()) has_value(line, "model name", model);
    has_value(line, "CPU implementer", implementer);
    if (!has_value(line, "CPU part", part)) continue;
    const std::string core = arm_core(implementer, part);
    if (std::find(cores.begin(), cores.end(), core) == cores.end()) cores.push_back(core);
  }
  // Some ARM kernels give a model's name as well, but it says no more than "ARMv8 Processor".
  std::string name = cores.empty() ? model : cores.front();
  for (std::size_t k = 1; k < cores.size(); ++k) name += " and " + cores[k];
  if (name.empty()) return board.empty() ? "unknown processor" : board;
  return cores.empty() || board.empty() ? name : name + ", " + board;
}

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo"), file("/proc/device-tree/model");
  std::string board{std::istreambuf_iterator<char>(file), {}};
  std::erase(board, '\0');  // its end, in a device tree
  return processor_name(cpuinfo, board);
}

}  // namespace parloc
