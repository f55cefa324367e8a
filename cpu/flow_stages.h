// The stages of flow and Kalman filters as OpenMP loops; contract in common/flow/flow_backend.h.
#pragma once

#include "common/flow/cloud_moments.h"
#include "common/flow/cloud_move.h"
#include "common/flow/flow_state.h"
#include "cpu/distance_sum.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

/// Fills `table`, distance_table_size() entries, from squared distances [cells^2], width x height.
void distance_table(const std::vector<std::uint32_t>& squared_cells, std::int32_t width, std::int32_t height,
                    Workers& workers, std::vector<DistancePair>& table);
/// Mean, and if asked for covariance, of particles whose weights add up to `total`.
void cloud_moments(const Cloud& cloud, double total, bool covariance, Moments& moments, Workers& workers);
void predict_mean(const FlowRules& rules, const MotionStep& motion, FlowState& state);
/// Changes which beams of `scan` count.
void reject_beams(const DistanceField& field, const FlowRules& rules, const FlowState& state,
                  PaddedScan& scan, BeamNotes& notes);
void update_mean(const DistanceField& field, const FlowRules& rules, const PaddedScan& scan, FlowState& state,
                 CloudMove& move, BeamNotes& notes);
void move_cloud(const Particles& particles, const CloudMove& move, RandomKey key, Workers& workers);
void flow_particles(const DistanceField& field, const FlowRules& rules, const PaddedScan& scan,
                    const MotionStep& motion, RandomKey key, const FlowState& state,
                    const Particles& particles, Workers& workers);

}  // namespace parloc::cpu
