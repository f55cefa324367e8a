#include "tools/report/machine/machine_json.h"

#include "tools/report/machine/build_info.h"

namespace parloc::tools {

using Json = nlohmann::ordered_json;

Json text_or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json build_json() {
  return {{"version", kVersion}, {"commit", text_or_null(kCommit)}, {"compiler", kCompiler},
          {"flags", kFlags},     {"build_type", kBuildType},        {"cuda", kCuda}};
}

Json machine_json(const Machine& m) {
  return {{"cpu", m.cpu},
          {"cores", m.cores},
          {"memory_bytes", m.memory_bytes},
          {"os", m.os},
          {"load_average", m.load_average >= 0.0 ? Json(m.load_average) : Json(nullptr)},
          {"gpu_driver", text_or_null(m.gpu_driver)},
          {"devices", m.devices},
          {"settings", m.settings}};
}

std::string file_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace parloc::tools
