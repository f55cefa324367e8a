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
  bool covariance;
  PARLOC_HD void operator()(unsigned t, const double* sums) const {
    if (t > 0) return;
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
  const Cloud& cloud = args.cloud;
  const Particles& p = cloud.particles;
  block_sum<kCloudMeanSums>(p, MeanTerm{cloud}, FinishMoments{args, false}, queue);
  if (args.covariance)
    block_sum<kCloudCovarianceSums>(p, CovarianceTerm{cloud, args.state}, FinishMoments{args, true}, queue);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
