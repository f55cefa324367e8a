// What the sensor models read of the map, in the memory of a backend.
#pragma once

#include <cstdint>
#include <vector>

#include "common/filter/bind.h"
#include "common/filter/start.h"
#include "common/map/grid_map.h"
#include "common/map/rays/skip_field.h"
#include "common/map/rays/wall_index.h"

namespace parloc {

template <class Space>
class MapTables {
 public:
  using Queue = typename Space::Queue;

  /// `threads`: of the host, while tables are made; 0: all cores.
  void set_map(const GridMap& map, const SensorConfig& sensor, bool injects, int threads, Queue& queue) {
    map_ = map;
    if (!casts_rays(sensor.model)) field_.reserve(table_size(map.width, map.height));
    if (injects) {
      std::vector<std::uint32_t> cells = free_cells(map);
      free_count_ = cells.size();
      free_cells_.take(std::move(cells), queue);
    }
    if (casts_rays(sensor.model))
      prepare_rays(map, sensor, threads, queue);
    else
      measure_distances(map, queue);
    wall_count_ = static_cast<std::uint32_t>(map.walls.size());
    map_.walls.clear();
    map_.walls.shrink_to_fit();
    map_.cells.clear();
    map_.cells.shrink_to_fit();
  }

  /// The table of the likelihood field. Returns whether what stages are told of it has changed.
  bool set_range_max(double range_max_m, const SensorConfig& sensor, Queue& queue) {
    const DistanceLikelihood likelihood = bind_distance(sensor, map_.resolution_m, range_max_m);
    const bool changes = likelihood.unit_nat() != field_unit_nat_;
    field_unit_nat_ = likelihood.unit_nat();
    Space::likelihood_table(squared_distance_.data(), map_.width, map_.height, likelihood, field_.data(),
                            queue);
    return changes;
  }

  RayMap ray_map() {
    const Walls walls{walls_.data(), wall_ids_.data(), wall_first_.data(), wall_count_};
    return bind_ray_map(skip_.data(), skip_planes_, map_, walls);
  }
  LikelihoodField field(const SensorConfig& sensor) {
    return bind_field(field_.data(), field_unit_nat_, sensor, map_);
  }
  BeamSkip beam_skip(const SensorConfig& sensor) {
    return bind_beam_skip(sensor, sensor.do_beamskip ? squared_distance_.data() : nullptr, map_.width,
                          map_.height, static_cast<float>(map_.resolution_m));
  }
  FreeSpace free_space() { return bind_free_space(free_cells_.data(), free_count_, map_); }

 private:
  template <class T>
  using Array = typename Space::template Array<T>;

  void measure_distances(const GridMap& map, Queue& queue) {
    Array<std::uint8_t> occupied;
    occupied.take(blocking_cells(map, false), queue);
    squared_distance_.reserve(map.size());
    Space::squared_distance_field(occupied.data(), map.width, map.height, squared_distance_.data(), queue);
    queue.wait();  // before `occupied` goes
  }
  void prepare_rays(const GridMap& map, const SensorConfig& sensor, int threads, Queue& queue) {
    WallIndex index = map.walls.empty() ? WallIndex{} : index_walls(map);
    const std::vector<std::uint8_t> blocks =
        map.walls.empty() ? blocking_cells(map, sensor.unknown_blocks) : std::move(index.blocks);
    SkipField skip = skip_field(blocks.data(), map.width, map.height, Space::kMostSkipBytes, threads);
    skip_planes_ = skip.planes;
    skip_.take(std::move(skip.lines), queue);
    walls_.take(std::move(index.walls), queue);
    wall_ids_.take(std::move(index.ids), queue);
    wall_first_.take(std::move(index.first), queue);
  }

  GridMap map_;  // without its cells and walls
  Array<std::uint32_t> squared_distance_;
  Array<std::uint8_t> skip_;
  SkipPlanes skip_planes_;
  Array<RayWall> walls_;
  Array<std::uint32_t> wall_ids_, wall_first_;
  std::uint32_t wall_count_ = 0;
  Array<std::uint32_t> field_;
  float field_unit_nat_ = 0;
  Array<std::uint32_t> free_cells_;  // only where particles are injected
  std::size_t free_count_ = 0;
};

}  // namespace parloc
