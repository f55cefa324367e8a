#include "cpu/flow_stages.h"

namespace parloc::cpu {
namespace {

/// The lower one of an even number; reorders the values.
float median(float* values, std::size_t count) {
  float* middle = values + (count - 1) / 2;
  std::nth_element(values, middle, values + count);
  return *middle;
}

}  // namespace

void FlowStages::reject_beams(const FlowArgs& args, FlowRoom& room, Queue&) {
  PaddedScan& scan = room.scan;
  if (scan.hits == 0) return;
  const StrictFloat strict;
  const DistanceField& field = args.field;
  const ScanPose pose = scan_pose(args.state->prior.mean, field);
  float* distance = room.notes.right;  // both are free until the scan is summed
  float* sorted = room.notes.up;
  for (std::size_t m = 0; m < scan.hits; ++m)
    distance[m] = look_up(field, pose, beam_arm(pose, scan.end_x[m], scan.end_y[m])).distance;
  std::copy_n(distance, scan.hits, sorted);
  const float middle = median(sorted, scan.hits);
  for (std::size_t m = 0; m < scan.hits; ++m) sorted[m] = __builtin_fabsf(distance[m] - middle);
  const float deviation = median(sorted, scan.hits);
  scan.kept = 0.0f;
  for (std::size_t m = 0; m < scan.hits; ++m) {
    scan.keep[m] = is_usual(distance[m], middle, deviation, args.rules.z_score) ? 1.0f : 0.0f;
    scan.kept += scan.keep[m];
  }
}

}  // namespace parloc::cpu
