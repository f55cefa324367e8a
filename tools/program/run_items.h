// What many trials need: their logs, and threads that do piece after piece and can be stopped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/eval/trial.h"
#include "common/io/log.h"
#include "common/io/log_choice.h"

namespace parloc::tools {

struct ItemsRequest {
  std::size_t items = 0;
  int threads = 1;
  std::function<bool()> stop;  ///< Asked often, on the caller's thread; may be empty.
  std::function<void()> tell;  ///< Called as often; may be empty.
};

/// Whether to go on: false once `stop` said so, or after an error in another thread.
using KeepGoing = std::function<bool()>;
/// Does one item. Only one thread calls it, so that it may have things of its own.
using Worker = std::function<void(std::size_t item)>;

/// Calls `make_worker` once in each thread, and the workers with the items from 0 on as they get free. The
/// first error ends the work and is thrown.
void run_items(const ItemsRequest& request,
               const std::function<Worker(std::size_t thread, const KeepGoing& keep_going)>& make_worker);

struct LogSource {
  std::function<TrialLog(std::uint64_t seed)> log_of;  ///< May be called from several threads.
  std::string what;                                    ///< For people: where the logs come from.
};

inline bool is_scan(const LogRecord& r) {
  return r.kind == RecordKind::scan;
}

/// All of a log, and how many broken lines were skipped. Throws Error{input} as the readers, and without a
/// scan.
std::vector<LogRecord> read_whole_log(const std::string& path, const LogChoice& choice,
                                      std::size_t& broken_lines);

}  // namespace parloc::tools
