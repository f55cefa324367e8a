// A configuration as Python has it.
#pragma once

#include <utility>

#include "common/config/config.h"
#include "common/config/config_settings.h"
#include "common/settings/setting.h"

namespace parloc::python {

/// Every setting that there is, and the table that points to them: hence neither copied nor moved.
struct ConfigBox {
  explicit ConfigBox(Config c = {}) : config(std::move(c)), table(settings_of(config)) {}
  ConfigBox(const ConfigBox&) = delete;
  ConfigBox& operator=(const ConfigBox&) = delete;

  Config config;
  const Settings table;
};

/// What a constructor was given: null stands for the defaults.
inline Config config_or_default(const ConfigBox* box) {
  return box != nullptr ? box->config : Config();
}

}  // namespace parloc::python
