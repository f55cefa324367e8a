// The stages as kernels; contract in common/filter/stages.h. All are asynchronous on `stream` and can be
// recorded: what changes from step to step (motion, random key, scan) they read from `input`, in device
// memory, and not from their arguments.
#pragma once

#include "common/filter/bins.h"
#include "common/filter/kld.h"
#include "common/filter/stages.h"
#include "cuda/launch.h"
#include "cuda/memory.h"
#include "cuda/step_input.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// Scratch of the collective stages, sized once for a particle count.
struct Scratch {
  DeviceBuffer<double> sums;
  DeviceBuffer<std::uint64_t> best;  // [2] heaviest weight, its smallest key
  DeviceBuffer<unsigned char> scan;  // CUB's
  void reserve(std::size_t particles);
};

void predict(const Particles& particles, const StepInput* input, Stream stream);
void ray_trace(const RayTraceArgs& args, const StepInput* input, Stream stream);
/// Only for models that ask all particles about a beam (needs_beam_votes); before weight.
void beam_votes(const WeightArgs& args, const StepInput* input, Stream stream);
void weight(const WeightArgs& args, const StepInput* input, Stream stream);
void normalise_scan(const NormaliseArgs& args, Scratch& scratch, Stream stream);
void estimate(const Particles& particles, const Weights& weights, const BinTable& bins, StepState* state,
              Scratch& scratch, Stream stream);
/// Only where the number of particles adapts; before resample.
void adapt(const AdaptArgs& args, const StepInput* input, Scratch& scratch, Stream stream);
void resample(const ResampleArgs& args, const StepInput* input, Scratch& scratch, Stream stream);

/// Makes a new table empty; estimate() leaves it so.
void clear_all_bins(const BinTable& bins, Stream stream);
/// Empties a table that has at most so many bins.
void clear_used_bins(const BinTable& bins, std::size_t most, Stream stream);

/// out[i] = in[0] + ... + in[i]; in == out is allowed.
void inclusive_scan(const std::uint64_t* in, std::uint64_t* out, std::size_t count, Scratch& scratch,
                    Stream stream);

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
