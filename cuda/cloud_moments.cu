#include "cuda/block_sum.h"
#include "cuda/flow_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {
namespace {

struct MeanTerm {
  Cloud cloud;
  PARLOC_HD SumVector<kCloudMeanSums> operator()(std::size_t i) const { return cloud.mean_terms_of(i); }
};

struct CovarianceTerm {
  Cloud cloud;
  const FlowState* state;
  PARLOC_HD SumVector<kCloudCovarianceSums> operator()(std::size_t i) const {
    return cloud.covariance_terms_of(i, state->cloud);
  }
};

struct FinishMoments {
  CloudMomentsArgs args;
  const double* sums;
  bool covariance;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() != 0) return;
    const double total = args.weighed != nullptr ? static_cast<double>(args.weighed->total)
                                                 : static_cast<double>(args.cloud.particles.count());
    if (covariance)
      finish_covariance(args.state->cloud, sums, total);
    else
      finish_mean(args.state->cloud, sums, total, total);
  }
};

}  // namespace

void FlowStages::cloud_moments(const CloudMomentsArgs& args, Queue& queue) {
  double* room = queue.scratch.sums.data();
  const Cloud& cloud = args.cloud;
  const Particles& p = cloud.particles;
  const double* mean = block_sum<kCloudMeanSums>(p, MeanTerm{cloud}, room, queue);
  launch(FinishMoments{args, mean, false}, 1, queue);
  if (!args.covariance) return;
  const double* sums = block_sum<kCloudCovarianceSums>(p, CovarianceTerm{cloud, args.state}, room, queue);
  launch(FinishMoments{args, sums, true}, 1, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
