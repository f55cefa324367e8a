// What a step of these filters is told and what it leaves: plain data that both backends keep.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/filter/stages.h"
#include "common/flow/exact_flow.h"
#include "common/flow/field_measurement.h"
#include "common/flow/kalman_update.h"
#include "common/flow/pose_gaussian.h"

namespace parloc {

/// Why a scan changed nothing.
enum class FlowSkip : std::uint32_t {
  none,
  no_scan,    ///< None in this step, or too few beams for it to count.
  no_slope,   ///< No beam ends near a wall of the map.
  gated,      ///< It lies farther off than flow.gate_nis.
  no_update,  ///< The information matrix could not be inverted.
};

constexpr bool is_kalman(FlowMethod m) {
  return m == FlowMethod::ekf || m == FlowMethod::ekf_beams;
}
/// All particles move by one map.
constexpr bool moves_as_one(FlowMethod m) {
  return m == FlowMethod::edh || m == FlowMethod::naedh || m == FlowMethod::gromov;
}

/// Everything that is the same in all steps of a filter.
struct FlowRules {
  FlowMethod method = FlowMethod::naedh;
  bool euler = false;
  FlowPrior prior = FlowPrior::recentred;
  FieldInterpolation interpolation = FieldInterpolation::bilinear;
  FlowTimes times;
  float cap_cells = 0.0f;
  double resolution_m = 0.0;
  PsiNoise noise;
  GateRule gate;
  double z_score = 0.0;
  InformationTerms information;  ///< ekf_beams
  int iterations = 0;            ///< ekf_beams
  float pfpf_sigma_xy = 0.0f, pfpf_sigma_theta = 0.0f;
};

/// All of it lies in the backend's memory and comes up after a step.
struct FlowState {
  PoseGaussian posterior;  ///< Of the last step; the prior of this one follows from it.
  PoseGaussian prior;      ///< Before the scan.
  Vector3 centre;          ///< Where the flow starts from: the particles' mean before the scan, in float32.
  Moments cloud;           ///< Of the particles after the step (filters without any: unused).
  FieldMeasurement scan;   ///< At the prior.
  double nis = 0.0;        ///< Of that.
  double stiffness = 0.0;  ///< s / r of that: Euler steps lag behind from about 100.
  double r_scale = 1.0;    ///< By which the gate widened the noise.
  FlowSkip skip = FlowSkip::no_scan;
};

/// Whether a distance is like those of the other beams (SPEC 8.3): by how far it is from their median, in
/// units of the median of that. All are where that is 0.
PARLOC_HD bool is_usual(float distance, float median, float deviation, double z_score) {
  if (deviation == 0.0f) return true;
  return 0.6745 * static_cast<double>(__builtin_fabsf(distance - median)) <
         z_score * static_cast<double>(deviation);
}

}  // namespace parloc
