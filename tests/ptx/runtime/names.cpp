#include "tests/ptx/runtime/names.h"

#include <cxxabi.h>

#include <cstdlib>
#include <memory>
#include <regex>

namespace ptx {

std::string plain_name(const std::string& name) {
  static const std::regex start(R"((\d+)(?=_GLOBAL__N__|_INTERNAL_|CUB_|THRUST_))");
  static const std::regex numbered(
      R"((_GLOBAL__N_|_INTERNAL)_[0-9a-f]{8}_\d+_(\w+)_cu_[0-9a-f]{8}|(CUB|THRUST)_\d+_SM_[\d_]+(?:NS)?)");
  std::string plain;
  std::size_t done = 0;
  for (std::sregex_iterator at(name.begin(), name.end(), start), end; at != end; ++at) {
    const std::string length = at->str(1);
    const auto first = static_cast<std::size_t>(at->position() + at->length());
    for (std::size_t skipped = 0; skipped < length.size(); ++skipped) {
      const std::string identifier = name.substr(first, std::stoul(length.substr(skipped)));
      std::smatch found;
      if (!std::regex_match(identifier, found, numbered)) continue;
      const std::string word = found.str(1) + found.str(2) + found.str(3);
      plain += name.substr(done, static_cast<std::size_t>(at->position()) + skipped - done);
      plain += std::to_string(word.size()) + word;
      done = first + identifier.size();
      break;
    }
  }
  return plain + name.substr(done);
}

std::string readable_name(const std::string& name) {
  int status = 0;
  const std::unique_ptr<char, void (*)(void*)> text(
      abi::__cxa_demangle(name.c_str(), nullptr, nullptr, &status), std::free);
  if (status != 0) return name;
  std::string readable = text.get();
  readable =
      std::regex_replace(readable, std::regex(R"(^void |\(anonymous namespace\)::|parloc::cuda::)"), "");
  std::smatch found;
  if (std::regex_match(readable, found, std::regex(R"(run_kernel<(.*)>\(.*\))"))) return found.str(1);
  return readable.substr(0, readable.find('('));
}

}  // namespace ptx
