// The stages of flow and Kalman filters as OpenMP loops; contract in common/flow/flow_stages.h.
#pragma once

#include "common/filter/engine/step_input_buffer.h"
#include "common/flow/flow_stages.h"
#include "cpu/distance_sum.h"
#include "cpu/parallel.h"

namespace parloc::cpu {

struct FlowRoom {
  explicit FlowRoom(const FlowConfig&) {}
  template <class Space>
  void set_scan(const BeamTable& t, StepInputBuffer<Space>&) {
    scan.set(t);
  }
  PaddedScan scan;
  BeamNotes notes;
};

struct FlowStages {
#include "common/flow/stage_list.inc"
};

}  // namespace parloc::cpu
