#include <algorithm>

#include "cuda/draft_maps.h"
#include "cuda/match_sum.h"

namespace parloc {
namespace PARLOC_CUDA_NAMESPACE {
namespace {

/// A block per task. Its first thread decides which poses are looked at next; warps take one each.
struct MatchScans {
  struct Shared {
    unsigned char search[sizeof(ScanSearch)];
    PoseSums sums;
    std::int32_t bound[WideSearch::kMostBlocks];
  };
  MatchRules rules;
  const MatchTask* task;
  std::size_t tasks;
  int most_rounds;
  FoundPose* found;

  PARLOC_HD int phases() const { return 2 + 2 * most_rounds; }
  PARLOC_HD void operator()(const Thread& me, int phase, Shared& s) const {
    if (me.block >= tasks) return;
    const MatchTask& mine = task[me.block];
    ScanSearch& search = *reinterpret_cast<ScanSearch*>(s.search);
    const int round = phase / 2;
    if (phase % 2 == 1)
      return s.sums.answer(me, round, s.sums.wanted, search, mine, mine.map, mine.scan, rules);
    s.sums.clear(me.thread, round);
    if (me.thread > 0 || (phase > 0 && s.sums.wanted == 0)) return;
    if (phase == 0) {
      search = ScanSearch{};
      search.begin(mine.start, mine);
    } else {
      search.take(s.sums.sums(round - 1), s.bound, mine);
    }
    s.sums.wanted = search.wanted();
    if (s.sums.wanted == 0) found[me.block] = found_pose(search, mine.beams);
  }
};

class CudaScanMatcher final : public ScanMatcher {
 public:
  explicit CudaScanMatcher(const ScanMatcherConfig& config)
      : ScanMatcher(config.rules), queue_(config.device), maps_(config.rules, queue_) {}
  void clear() override {
    queue_.use();
    maps_.clear();
  }
  void draw(const std::vector<ScanDrawing>& drawings) override {
    queue_.use();
    maps_.draw(drawings);
  }
  std::vector<ScanMatch> match(const std::vector<ScanQuery>& queries) override {
    queue_.use();
    std::vector<const BeamTable*> tables;
    for (const ScanQuery& q : queries) tables.push_back(q.scan);
    const std::vector<Beams> beams = scans_.upload(tables, queue_);
    std::vector<MatchTask> tasks;
    int most_rounds = 0;
    for (std::size_t k = 0; k < queries.size(); ++k) {
      tasks.push_back(bind_query(queries[k], maps_.view(queries[k].map), beams[k], rules()));
      most_rounds = std::max(most_rounds, ScanSearch::most_rounds(queries[k].search));
    }
    task_.from_host(tasks, queue_);
    found_.reserve(tasks.size());
    if (!tasks.empty())
      launch(MatchScans{rules().match, task_.data(), tasks.size(), most_rounds, found_.data()},
             static_cast<unsigned>(tasks.size()), queue_);
    std::vector<ScanMatch> matches;
    for (const FoundPose& f : found_.to_host(tasks.size(), queue_)) matches.push_back(match_of(f));
    return matches;
  }
  SlamCells cells(std::size_t map) override {
    queue_.use();
    return maps_.cells(map);
  }

 private:
  Queue queue_;
  DraftMaps maps_;
  DeviceScans scans_;
  DeviceBuffer<MatchTask> task_;
  DeviceBuffer<FoundPose> found_;
};

}  // namespace

#if !defined(__CUDACC__)
std::unique_ptr<ScanMatcher> make_scan_matcher_on_host(const ScanMatcherConfig& config) {
  return std::make_unique<CudaScanMatcher>(config);
}
#endif
}  // namespace PARLOC_CUDA_NAMESPACE

#if defined(__CUDACC__)
std::unique_ptr<ScanMatcher> make_cuda_scan_matcher(const ScanMatcherConfig& config) {
  return std::make_unique<cuda::CudaScanMatcher>(config);
}
#endif

}  // namespace parloc
