#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct ReportScan {
  SlamArgs args;
  const std::uint64_t* used;
  SlamReport to;
  PARLOC_HD void operator()(const Thread& me) const {
    for (std::size_t i = me.first(); i < args.particles.count(); i += me.stride()) report_one(args, to, i);
    if (me.first() == 0) *to.head = {*args.tally, *used, *args.state};
  }
};

}  // namespace

void SlamStages::report_scan(const SlamArgs& args, const TileStore& store, const SlamReport& to,
                             Queue& queue) {
  launch(ReportScan{args, store.used(), to}, blocks_for(args.particles.capacity), queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
