// The stages as OpenMP loops; contract in common/filter/stages.h. `workers` has at least one thread.
#pragma once

#include "common/filter/bins.h"
#include "common/filter/kld.h"
#include "common/filter/stages.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

void predict(const PredictArgs& args, Workers& workers);
void ray_trace(const RayTraceArgs& args, Workers& workers);
/// Only for models that ask all particles about a beam (needs_beam_votes); before weight.
void beam_votes(const WeightArgs& args, Workers& workers);
void weight(const WeightArgs& args, Workers& workers);
void normalise_scan(const NormaliseArgs& args, Workers& workers);
void estimate(const Particles& particles, const Weights& weights, const BinTable& bins, StepState* state,
              Workers& workers);
/// Only where the number of particles adapts; before resample.
void adapt(const AdaptArgs& args, Workers& workers);
void resample(const ResampleArgs& args, Workers& workers);

}  // namespace parloc::cpu
