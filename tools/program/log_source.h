// The logs of many trials: simulated anew for every seed, or from a recorded log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/eval/trial.h"
#include "common/io/log.h"

namespace parloc::tools {

struct LogSource {
  std::function<TrialLog(std::uint64_t seed)> log_of;  ///< May be called from several threads.
  std::string what;                                    ///< For people: where the logs come from.
};

inline bool is_scan(const LogRecord& r) {
  return r.kind == RecordKind::scan;
}

/// All of a log, and how many broken lines were skipped. Throws Error{input} as the readers, and without a
/// scan.
std::vector<LogRecord> read_whole_log(const std::string& path, std::size_t& broken_lines);

}  // namespace parloc::tools
