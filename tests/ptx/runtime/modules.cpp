#include "tests/ptx/runtime/modules.h"

#include <cstring>
#include <map>
#include <string>
#include <unordered_map>

#include "tests/ptx/runtime/device_memory.h"
#include "tests/ptx/runtime/names.h"
#include "tests/ptx/runtime/report.h"

namespace ptx {
namespace {

std::unordered_map<const void*, std::string>& names() {
  static std::unordered_map<const void*, std::string> by_host;
  return by_host;
}

struct Tables {
  std::map<std::string, const Kernel*> kernels;
  std::map<std::string, const Symbol*> symbols;
};

/// Gives a variable its memory and its first value.
void place(Symbol& symbol) {
  DeviceMemory& memory = DeviceMemory::instance();
  symbol.address = memory.allocate(symbol.size);
  if (symbol.address == 0) fault(std::string("no memory for the variable ") + symbol.name);
  char* bytes = memory.bytes_at(symbol.address);
  if (symbol.initial != nullptr)
    std::memcpy(bytes, symbol.initial, symbol.size);
  else
    std::memset(bytes, 0, symbol.size);
}

Tables load() {
  Tables tables;
  for (const Module* const* module = modules; *module != nullptr; ++module) {
    for (std::size_t i = 0; i < (*module)->kernel_count; ++i)
      tables.kernels.emplace((*module)->kernels[i].name, &(*module)->kernels[i]);
    for (std::size_t i = 0; i < (*module)->symbol_count; ++i) {
      Symbol& symbol = (*module)->symbols[i];
      place(symbol);
      tables.symbols.emplace(symbol.name, &symbol);
    }
  }
  return tables;
}

const Tables& tables() {
  static const Tables loaded = load();
  return loaded;
}

template <class Entry>
const Entry& find(const std::map<std::string, const Entry*>& entries, const void* host, const char* what) {
  const auto name = names().find(host);
  if (name == names().end()) fault(std::string("an address that is no ") + what);
  const auto entry = entries.find(name->second);
  if (entry == entries.end())
    fault(std::string("there is no PTX of the ") + what + " " + readable_name(name->second));
  return *entry->second;
}

}  // namespace

void register_kernel(const void* host, const char* name) {
  names()[host] = plain_name(name);
}
void register_symbol(const void* host, const char* name) {
  names()[host] = plain_name(name);
}
const Kernel& kernel_of(const void* host) {
  static std::unordered_map<const void*, const Kernel*> seen;
  const Kernel*& kernel = seen[host];
  if (kernel == nullptr) kernel = &find(tables().kernels, host, "kernel");
  return *kernel;
}
const Symbol& symbol_of(const void* host) {
  return find(tables().symbols, host, "variable");
}

}  // namespace ptx
