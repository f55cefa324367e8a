#include "tools/slam/map_position.h"

#include <sstream>

#include "common/file/bytes.h"
#include "common/slam/checkpoint_values.h"

namespace parloc::tools::slam {
namespace {

/// Cells as runs of the same.
void put_map(ByteWriter& w, const GridMap& map) {
  w.put(map.width), w.put(map.height);
  w.put(map.resolution_m);
  put_pose(w, map.T_map_grid);
  w.put_text(map.name);
  std::vector<std::uint32_t> length;
  std::vector<std::uint8_t> value;
  for (const Cell cell : map.cells) {
    if (value.empty() || value.back() != static_cast<std::uint8_t>(cell))
      length.push_back(0), value.push_back(static_cast<std::uint8_t>(cell));
    ++length.back();
  }
  w.put(length), w.put(value);
}

GridMap get_map(ByteReader& r) {
  GridMap map;
  map.width = r.get<std::int32_t>(), map.height = r.get<std::int32_t>();
  map.resolution_m = r.get<double>();
  map.T_map_grid = get_pose(r);
  map.name = r.get_text();
  const auto fits = [](std::int32_t side) { return side > 0 && side <= Growth::most_cells; };
  r.expect(fits(map.width) && fits(map.height) && map.resolution_m > 0.0, "a small map");
  const auto size = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  const auto length = r.get_vector<std::uint32_t>();
  const auto value = r.get_vector<std::uint8_t>();
  r.expect(length.size() == value.size(), "a value for each run of cells");
  for (std::size_t k = 0; k < length.size(); ++k) {
    r.expect(length[k] <= size - map.cells.size() && value[k] <= static_cast<std::uint8_t>(Cell::unknown),
             "the cells of a map");
    map.cells.insert(map.cells.end(), length[k], static_cast<Cell>(value[k]));
  }
  r.expect(map.cells.size() == size, "all cells of a map");
  return map;
}

void put_particle(ByteWriter& w, const Particle& p) {
  w.put(p.x_m), w.put(p.y_m), w.put(p.theta_rad), w.put(p.weight);
}
Particle get_particle(ByteReader& r) {
  Particle p;
  p.x_m = r.get<float>(), p.y_m = r.get<float>(), p.theta_rad = r.get<float>(), p.weight = r.get<float>();
  return p;
}

void put_growth(ByteWriter& w, const Growth& g) {
  w.put(g.state.stamp_s);
  put_pose(w, g.state.pose);
  w.put_each(g.state.particles, put_particle);
  put_map(w, g.map);
  put_trajectory(w, g.path);
  w.put(g.distance_m), w.put(g.n_eff);
  for (const std::size_t n : {g.scans, g.taken_in, g.resampled, g.particles}) w.put_count(n);
  for (const std::size_t n : g.distinct) w.put_count(n);
  for (const std::size_t n :
       {g.memory.tile_bytes, g.memory.most_tile_bytes, g.memory.table_bytes, g.memory.sub_map_bytes})
    w.put_count(n);
}

Growth get_growth(ByteReader& r) {
  Growth g;
  g.state.stamp_s = r.get<double>();
  g.state.pose = get_pose(r);
  g.state.particles = r.get_each(16, get_particle);
  g.map = get_map(r);
  g.path = get_trajectory(r);
  g.distance_m = r.get<double>(), g.n_eff = r.get<double>();
  for (std::size_t* n : {&g.scans, &g.taken_in, &g.resampled, &g.particles}) *n = r.get<std::uint64_t>();
  for (std::size_t& n : g.distinct) n = r.get<std::uint64_t>();
  for (std::size_t* n :
       {&g.memory.tile_bytes, &g.memory.most_tile_bytes, &g.memory.table_bytes, &g.memory.sub_map_bytes})
    *n = r.get<std::uint64_t>();
  return g;
}

}  // namespace

std::string to_bytes(const MapPosition& position) {
  std::string bytes;
  ByteWriter w(
      [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); });
  w.put_text(position.log_name);
  w.put_count(position.scans);
  w.put_text(position.digest);
  w.put(position.step_s);
  w.put(position.wall_s);
  w.put_bool(position.odometry_chosen);
  w.put_each(position.growth, put_growth);
  w.flush();
  return bytes;
}

MapPosition map_position_from(const std::string& bytes, const std::string& name) {
  std::istringstream in(bytes, std::ios::binary);
  ByteReader r(in, bytes.size(), name);
  MapPosition position;
  position.log_name = r.get_text();
  position.scans = r.get<std::uint64_t>();
  position.digest = r.get_text();
  position.step_s = r.get_vector<double>();
  position.wall_s = r.get<double>();
  position.odometry_chosen = r.get_bool();
  position.growth = r.get_each(100, get_growth);
  return position;
}

}  // namespace parloc::tools::slam
