// What `parloc log info` says.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/model/scan_config.h"
#include "tools/log/bag_survey.h"
#include "tools/log/log_survey.h"

namespace parloc::tools {

struct LogInfo {
  std::string path;
  std::vector<LidarConfig> lidars;  ///< What the settings say of them.
  std::optional<BagSurvey> bag;     ///< If it is one.
  SuggestedChoice suggested;        ///< Of a bag.
  std::optional<LogSurvey> log;     ///< Nothing: see trouble.
  std::string trouble;              ///< Why it cannot be read as a log.
};

/// For people: a line or some per thing, then the command lines that would run it.
std::string info_text(const LogInfo& info);
/// The same numbers: seconds, metres, radians.
std::string info_json(const LogInfo& info);

}  // namespace parloc::tools
