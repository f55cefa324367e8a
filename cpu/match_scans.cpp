#include <omp.h>

#include "common/filter/bind.h"
#include "cpu/draft_maps.h"
#include "cpu/match_sum.h"
#include "cpu/parallel.h"

namespace parloc {
namespace cpu {
namespace {

void match_scans(const MatchRules& rules, const std::vector<MatchTask>& tasks, int threads,
                 std::vector<FoundPose>& found) {
  parallel_tasks(tasks.size(), threads, [&](std::size_t t) PARLOC_SIMD_LOOP {
    const MatchTask& task = tasks[t];
    std::int32_t sum[ScanSearch::kMostPoses], bound[WideSearch::kMostBlocks];
    BeamSums sums;
    ScanSearch search;
    search.begin(task.start, task);
    while (!search.done()) {
      for (int k = 0, n = search.wanted(); k < n; ++k)
        sum[k] =
            sums.sum(task.map, task.scan, match_pose(search.candidate(k, task), rules), rules, search.ask());
      search.take(sum, bound, task);
    }
    found[t] = found_pose(search, task.beams);
  });
}

class CpuScanMatcher final : public ScanMatcher {
 public:
  explicit CpuScanMatcher(const ScanMatcherConfig& config)
      : ScanMatcher(config.rules),
        threads_(config.threads > 0 ? config.threads : omp_get_num_procs()),
        maps_(config.rules, threads_) {}
  void clear() override { maps_.clear(); }
  void draw(const std::vector<ScanDrawing>& drawings) override { maps_.draw(drawings); }
  std::vector<ScanMatch> match(const std::vector<ScanQuery>& queries) override {
    std::vector<MatchTask> tasks;
    for (const ScanQuery& q : queries)
      tasks.push_back(bind_query(q, maps_.view(q.map), bind_beams(*q.scan), rules()));
    std::vector<FoundPose> found(tasks.size());
    match_scans(rules().match, tasks, threads_, found);
    std::vector<ScanMatch> matches;
    for (const FoundPose& f : found) matches.push_back(match_of(f));
    return matches;
  }
  SlamCells cells(std::size_t map) override {
    const TileMap drawn = maps_.view(map);
    return gather_cells(drawn.span, drawn.table, [&](const std::vector<std::uint32_t>& ids, Tile* to) {
      for (const std::uint32_t id : ids) *to++ = drawn.pool.at(id);
    });
  }

 private:
  int threads_;
  DraftMaps maps_;
};

}  // namespace
}  // namespace cpu

std::unique_ptr<ScanMatcher> make_cpu_scan_matcher(const ScanMatcherConfig& config) {
  return std::make_unique<cpu::CpuScanMatcher>(config);
}

}  // namespace parloc
