#include "tools/compare/run_all.h"

#include <fmt/format.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "common/config/pose_filters.h"
#include "common/error.h"
#include "tools/program/run_items.h"

namespace parloc::tools::compare {
namespace {

/// What all threads write to.
struct Board {
  Outcome outcome;  // `runs` at the end
  std::vector<std::vector<std::optional<FilterRun>>>
      runs;  // each written by the one thread that has its seed
  std::atomic<std::size_t> finished = 0;
  std::mutex mutex;  // of `outcome`
};

/// Seed by seed, so that a log is made once for all filters; these are a thread's own.
class SeedRunner {
 public:
  SeedRunner(const Request& request, const DriveSource& source, const GridMap& map, Board& board,
             KeepGoing keep_going)
      : request_(request),
        source_(source),
        map_(map),
        board_(board),
        keep_going_(std::move(keep_going)),
        filters_(request.entries.size()) {}

  void run(std::size_t s) {
    const std::uint64_t seed = request_.first_seed + s;
    const TrialLog log = source_.drive(seed);
    count(log);
    for (std::size_t k = 0; k < filters_.size() && keep_going_(); ++k) {
      if (!filters_[k]) filters_[k] = made(k);
      board_.runs[k][s] = followed(k, log, seed);
      if (board_.runs[k][s]) ++board_.finished;
    }
  }

 private:
  std::optional<FilterRun> followed(std::size_t k, const TrialLog& log, std::uint64_t seed) {
    try {
      return follow(*filters_[k], log, request_.start, seed, keep_going_);
    } catch (const Error& e) {
      throw Error(e.kind(), fmt::format("{}, seed {}: {}", request_.entries[k].label, seed, e.what()));
    }
  }
  std::unique_ptr<PoseFilter> made(std::size_t k) {
    const Entry& e = request_.entries[k];
    auto filter = make_pose_filter(e.kind, e.config, map_);
    const std::lock_guard lock(board_.mutex);
    board_.outcome.backends[k] = filter->backend_name();
    return filter;
  }
  void count(const TrialLog& log) {
    const std::lock_guard lock(board_.mutex);
    board_.outcome.hits += log.hits;
    board_.outcome.unmapped += log.unmapped;
  }

  const Request& request_;
  const DriveSource& source_;
  const GridMap& map_;
  Board& board_;
  KeepGoing keep_going_;
  std::vector<std::unique_ptr<PoseFilter>> filters_;
};

}  // namespace

Outcome run_all(const Request& request, const DriveSource& source, const GridMap& map) {
  Board board;
  board.outcome.backends.resize(request.entries.size());
  board.runs.resize(request.entries.size());
  for (auto& of_entry : board.runs) of_entry.resize(request.seeds);
  const auto tell = [&] {
    const auto all = static_cast<double>(request.seeds * request.entries.size());
    if (request.progress) request.progress(static_cast<double>(board.finished) / all, board.finished);
  };
  run_items({request.seeds, request.jobs, request.stop, tell},
            [&](std::size_t, const KeepGoing& keep_going) -> Worker {
              const auto runner = std::make_shared<SeedRunner>(request, source, map, board, keep_going);
              return [runner](std::size_t s) { runner->run(s); };
            });
  for (auto& of_entry : board.runs) {
    std::vector<FilterRun>& finished = board.outcome.runs.emplace_back();
    for (auto& one : of_entry)
      if (one) finished.push_back(std::move(*one));
  }
  board.outcome.finished = board.finished;
  return std::move(board.outcome);
}

}  // namespace parloc::tools::compare
