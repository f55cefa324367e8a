// Maps and scans for the filters on the distance field, and the mean distance of a scan in plain float64, to
// hold the float32 arithmetic against.
#pragma once

#include <memory>

#include "common/filter/bind.h"
#include "common/flow/field_measurement.h"
#include "common/map/grid_map.h"
#include "cpu/flow_stages.h"
#include "tests/unit/map_t1.h"
#include "tests/unit/measured_field.h"

namespace parloc::test {

/// The field of a map with its table.
struct MapField {
  std::vector<DistancePair> table;
  DistanceField field;
  MapField(const GridMap& map, float cap_m, FieldInterpolation how = FieldInterpolation::bilinear) {
    const auto occupied = blocking_cells(map, false);
    const auto squared = squared_distance_field(occupied.data(), map.width, map.height, 1);
    cpu::Queue queue;
    table.resize(distance_table_size(map.width, map.height));
    cpu::FlowStages::distance_table(squared.data(), map.width, map.height, table.data(), queue);
    field = {{table.data(), map.width, map.height},
             how,
             static_cast<float>(cap_m / map.resolution_m),
             map.resolution_m};
  }
  MapField(const MapField&) = delete;
  MapField& operator=(const MapField&) = delete;
};

inline constexpr float kNoCap_m = 1e5f;

/// Beams of a sensor on the robot, all hits.
inline BeamTable beams_of(const Pose& T_base_sensor, const std::vector<double>& bearings_rad,
                          const std::vector<float>& ranges_m, double resolution_m) {
  BeamTable t;
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    const double a = T_base_sensor.theta_rad + bearings_rad[i];
    t.origin_x.push_back(static_cast<float>(T_base_sensor.x_m));
    t.origin_y.push_back(static_cast<float>(T_base_sensor.y_m));
    t.direction_x.push_back(static_cast<float>(std::cos(a)));
    t.direction_y.push_back(static_cast<float>(std::sin(a)));
    t.range_m.push_back(ranges_m[i]);
    t.short_density.push_back(0.0f);
    t.end_x.push_back(static_cast<float>((T_base_sensor.x_m + ranges_m[i] * std::cos(a)) / resolution_m));
    t.end_y.push_back(static_cast<float>((T_base_sensor.y_m + ranges_m[i] * std::sin(a)) / resolution_m));
  }
  t.count = t.hits = ranges_m.size();
  t.range_max_m = 100.0f;
  measure_origins(t);
  return t;
}

/// The scan of the specification's worked example, section 7.3, and its pose in the grid frame of T1.
inline BeamTable example_beams() {
  return beams_of({0.1, 0.0, 0.0}, {0.0, M_PI / 2, M_PI, -M_PI / 2}, {1.25f, 1.30f, 1.35f, 0.60f}, 0.5);
}
inline Vector3 vector3(double a, double b, double c) {
  Vector3 v;
  v[0] = a, v[1] = b, v[2] = c;
  return v;
}
inline Vector3 example_pose() {
  return vector3(0.8 + 1.0, 0.15 + 2.0, 0.2);
}

/// What a scan says at a pose, as a step computes it.
inline FieldMeasurement measure(const DistanceField& field, const BeamTable& beams, const Vector3& pose) {
  const auto scan = std::make_unique<cpu::PaddedScan>();
  const auto notes = std::make_unique<cpu::BeamNotes>();
  scan->set(beams);
  const auto sum = cpu::sum_beams(field, *scan, scan_pose(pose, field), MeanTerms{}, *notes);
  return finish_measurement(sum, static_cast<double>(scan->kept), field);
}

/// Bilinear mean distance in float64, without a slope: the reference that is differentiated numerically.
inline double plain_psi_m(const GridMap& map, const BeamTable& beams, const Vector3& pose, double cap_m) {
  const auto occupied = blocking_cells(map, false);
  const auto squared = squared_distance_field(occupied.data(), map.width, map.height, 1);
  const auto distance = [&](int i, int j) {
    return std::sqrt(static_cast<double>(squared[static_cast<std::size_t>(j) * map.width + i]));
  };
  double sum_m = 0.0;
  for (std::size_t m = 0; m < beams.hits; ++m) {
    const double c = std::cos(pose[2]), s = std::sin(pose[2]);
    const double ex = beams.end_x[m], ey = beams.end_y[m];
    const double u = pose[0] / map.resolution_m - 0.5 + c * ex - s * ey;
    const double v = pose[1] / map.resolution_m - 0.5 + s * ex + c * ey;
    double d = 1e9;
    if (u >= -0.5 && v >= -0.5 && u < map.width - 0.5 && v < map.height - 0.5) {
      const int i = std::clamp(static_cast<int>(std::floor(u)), 0, map.width - 2);
      const int j = std::clamp(static_cast<int>(std::floor(v)), 0, map.height - 2);
      const double fx = std::clamp(u - i, 0.0, 1.0), fy = std::clamp(v - j, 0.0, 1.0);
      d = (1 - fy) * ((1 - fx) * distance(i, j) + fx * distance(i + 1, j)) +
          fy * ((1 - fx) * distance(i, j + 1) + fx * distance(i + 1, j + 1));
    }
    sum_m += std::min(d * map.resolution_m, cap_m);
  }
  return sum_m / static_cast<double>(beams.hits);
}

}  // namespace parloc::test
