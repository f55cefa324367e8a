// Settings of the sensor models: how well a scan fits the map at a pose.
#pragma once

namespace parloc {

/// How the likelihood of a scan is computed (SPEC 3).
enum class SensorModel {
  gaussian,  ///< Ranges along rays, with Gaussian noise (Paz et al. 2012).
  s5,        ///< The same; where only one of range and map ends within the maximum, a tail probability.
  beam,      ///< Ranges along rays: a mixture of hit, short, maximum and random (Thrun et al. 2005).
  class_conditional,      ///< The same mixture by what the beam met: return or none.
  likelihood_field,       ///< End points by their distance to a wall (Thrun et al. 2005).
  likelihood_field_prob,  ///< The same with beams skipped that few particles agree with, as in nav2.
};
/// Whether a model casts rays; the others look up end points.
constexpr bool casts_rays(SensorModel m) {
  return m != SensorModel::likelihood_field && m != SensorModel::likelihood_field_prob;
}

/// How a ray finds the wall.
enum class RayCaster {
  skip,        ///< Exact, over free space in large steps.
  dda,         ///< Exact, cell by cell; gives the bits of `skip`.
  fixed_step,  ///< By equal steps, as in Paz et al. 2012.
};
/// How the distance field is read at an end point.
enum class FieldLookup {
  nearest,   ///< That of the cell.
  bilinear,  ///< Between the middles of four cells.
};
/// p(scan | pose, map) (SPEC 3). One group for all models; each uses the keys it knows. These are the values
/// of the likelihood field; default_sensor() has those of the others.
struct SensorConfig {
  SensorModel model = SensorModel::likelihood_field;  ///< Which one.
  double sigma_hit = 0.1;  ///< Standard deviation of a range (ray models) or of a wall's place (field) [m].
  double z_hit = 0.9;      ///< Share of beams that end at the map's walls; the four sum to 1.
  double z_short = 0.0;    ///< Share of beams that something else stops.
  double z_max = 0.0;      ///< Share of beams that never return.
  double z_rand = 0.1;     ///< Share of beams that say nothing.
  double lambda_short = 0.5;               ///< Decay of the short beams [1/m].
  double laser_likelihood_max_dist = 2.0;  ///< Cap of the distance field [m].
  /// Independent beams that a scan is worth, however many it has: chosen so that the filter's covariance
  /// says how far off it is (docs/results/nees.md).
  double effective_beams = 9.0;
  double tempering = 0.0;            ///< beta of SPEC 3.2 as a number; 0: from effective_beams.
  double s5_epsilon = 1e-3;          ///< Weight of a beam beyond the maximum, measured and expected.
  bool do_beamskip = false;          ///< As in nav2's AMCL, and so the next three.
  double beam_skip_distance = 0.5;   ///< A particle agrees with a beam that ends this close to a wall [m].
  double beam_skip_threshold = 0.3;  ///< Share of the particles that must agree.
  double beam_skip_error_threshold = 0.9;      ///< Of so many beams skipped none is.
  double beam_skip_spread = 0.25;              ///< Standard deviation of the particles' place [m].
  FieldLookup lookup = FieldLookup::bilinear;  ///< Of models that look up end points.
  RayCaster caster = RayCaster::skip;          ///< Of models that cast rays.
  double fixed_step_cells = 0.5;               ///< Step of the fixed_step caster, in cells.
  bool unknown_blocks = true;                  ///< A ray ends at an unknown cell.
};

/// The defaults of a model. A file that chooses a model starts from these.
inline SensorConfig default_sensor(SensorModel model) {
  SensorConfig c;
  c.model = model;
  c.do_beamskip = model == SensorModel::likelihood_field_prob;
  if (!casts_rays(model)) return c;
  c.sigma_hit = 0.2;
  c.effective_beams = model == SensorModel::gaussian || model == SensorModel::s5 ? 0.4 : 6.0;
  if (model == SensorModel::beam) c.z_hit = 0.75, c.z_short = 0.1, c.z_max = 0.05, c.z_rand = 0.1;
  if (model == SensorModel::class_conditional)
    c.z_hit = 0.65, c.z_short = 0.2, c.z_max = 0.05, c.z_rand = 0.1;
  return c;
}

}  // namespace parloc
