#include "cpu/slam_stages.h"

namespace parloc::cpu {

void SlamStages::report_scan(const SlamArgs& args, const TileStore& store, const SlamReport& to,
                             Queue& workers) {
  for (std::size_t i = 0; i < args.particles.count(); ++i) report_one(args, to, i);
  *to.head = {*args.tally, store.used(workers), *args.state};
}

}  // namespace parloc::cpu
