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
  Cloud cloud;
  const StepState* weights;
  const double* sums;
  bool covariance;
  FlowState* state;
  PARLOC_HD void operator()(const Thread& me) const {
    if (me.first() != 0) return;
    const double total = weights != nullptr ? static_cast<double>(weights->total)
                                            : static_cast<double>(cloud.particles.count());
    if (covariance)
      finish_covariance(state->cloud, sums, total);
    else
      finish_mean(state->cloud, sums, total, total);
  }
};

}  // namespace

void cloud_moments(const Cloud& cloud, const StepState* weights, bool covariance, FlowState* state,
                   Scratch& scratch, Stream stream) {
  double* room = scratch.sums.data();
  const Particles& p = cloud.particles;
  const double* mean = block_sum<kCloudMeanSums>(p, MeanTerm{cloud}, room, stream);
  launch(FinishMoments{cloud, weights, mean, false, state}, 1, stream);
  if (!covariance) return;
  const double* sums = block_sum<kCloudCovarianceSums>(p, CovarianceTerm{cloud, state}, room, stream);
  launch(FinishMoments{cloud, weights, sums, true, state}, 1, stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
