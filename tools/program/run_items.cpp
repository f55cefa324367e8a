#include "tools/program/run_items.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/inputs/open_log.h"
#include "common/io/scan_stream.h"

namespace parloc::tools {

void run_items(const ItemsRequest& request,
               const std::function<Worker(std::size_t, const KeepGoing&)>& make_worker) {
  std::atomic<std::size_t> next = 0;
  std::atomic<int> running = request.threads;
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  std::exception_ptr error;
  const KeepGoing keep_going = [&] { return !stopped; };
  const auto work = [&](std::size_t thread) {
    try {
      const Worker worker = make_worker(thread, keep_going);
      for (std::size_t k = next++; k < request.items && !stopped; k = next++) worker(k);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
      stopped = true;
    }
    --running;
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < request.threads; ++k) threads.emplace_back(work, static_cast<std::size_t>(k));
  while (running > 0) {
    if (request.stop && request.stop()) stopped = true;
    if (request.tell) request.tell();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  for (std::thread& thread : threads) thread.join();
  if (error) std::rethrow_exception(error);
}

std::vector<LogRecord> read_whole_log(const std::string& path, const LogChoice& choice,
                                      std::size_t& broken_lines) {
  std::vector<LogRecord> records;
  const auto reader = open_log(path, choice);
  for (LogRecord record; reader->next(record);) records.push_back(std::move(record));
  broken_lines = reader->warnings().broken_lines;
  if (std::none_of(records.begin(), records.end(), is_scan)) throw no_scan(path, reader->warnings());
  return records;
}

}  // namespace parloc::tools
