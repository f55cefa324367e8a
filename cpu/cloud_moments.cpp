#include "cpu/block_sum.h"
#include "cpu/flow_stages.h"

namespace parloc::cpu {

void FlowStages::cloud_moments(const CloudMomentsArgs& args, Queue& workers) {
  const Cloud cloud = args.cloud;
  Moments& moments = args.state->cloud;
  const std::size_t count = cloud.particles.count();
  const double total = static_cast<double>(args.weighed != nullptr ? args.weighed->total : count);
  const auto mean = block_sum<kCloudMeanSums>(
      count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP { return cloud.mean_terms_of(i); });
  const StrictFloat strict;
  finish_mean(moments, mean.v, total, total);
  if (!args.covariance) return;
  const Moments about = moments;
  const auto sums = block_sum<kCloudCovarianceSums>(
      count, workers, [=](std::size_t i) PARLOC_SIMD_LOOP { return cloud.covariance_terms_of(i, about); });
  finish_covariance(moments, sums.v, total);
}

}  // namespace parloc::cpu
