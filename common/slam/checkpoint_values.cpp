#include "common/slam/checkpoint_values.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <unordered_map>

namespace parloc {
namespace {

// What arithmetic on a pose stands. Logs are held to less (docs/logs.md).
constexpr double kMostM = 1e12, kMostRad = 1e7;
/// Tiles from the map's origin: cells then are whole numbers of 32 bits with room to spare.
constexpr std::int32_t kFarthestTile = 1 << 24;
/// Tiles that are in host memory at once.
constexpr std::size_t kTilesAtOnce = 256;
constexpr std::size_t kCells = kTileCells * kTileCells;

/// from[k] becomes to[k].
void rename(std::vector<std::uint32_t>& table, const std::vector<std::uint32_t>& from,
            const std::vector<std::uint32_t>& to) {
  std::unordered_map<std::uint32_t, std::uint32_t> name{{kNoTile, kNoTile}};
  for (std::size_t k = 0; k < from.size(); ++k) name[from[k]] = to[k];
  for (std::uint32_t& id : table) id = name.at(id);
}

/// 1, 2, ...: places in a file.
std::vector<std::uint32_t> places(std::size_t count) {
  std::vector<std::uint32_t> out(count);
  for (std::size_t k = 0; k < count; ++k) out[k] = static_cast<std::uint32_t>(k + 1);
  return out;
}

template <class Take>
void in_batches(const std::vector<std::uint32_t>& ids, const Take& take) {
  for (std::size_t k = 0; k < ids.size(); k += kTilesAtOnce) {
    const auto begin = ids.begin() + static_cast<std::ptrdiff_t>(k);
    take(std::vector<std::uint32_t>(
        begin, begin + static_cast<std::ptrdiff_t>(std::min(kTilesAtOnce, ids.size() - k))));
  }
}

std::vector<float> get_floats(ByteReader& r, std::size_t count) {
  std::vector<float> values = r.get_vector<float>();
  r.expect(values.size() == count, "a number for every particle");
  return values;
}

TileSpan get_span(ByteReader& r) {
  TileSpan span;
  for (std::int32_t* v : {&span.first_i, &span.first_j, &span.width, &span.height}) {
    *v = r.get<std::int32_t>();
    r.expect(*v > -kFarthestTile && *v < kFarthestTile, "a map of a size that can be");
  }
  r.expect(span.width >= 0 && span.height >= 0 && (span.width == 0) == (span.height == 0),
           "a map of a size that can be");
  return span;
}

/// Where the particles are, the tables reach: the next step begins there.
void check_poses(const ByteReader& r, const SlamSnapshot& s, double resolution_m) {
  for (std::size_t k = 0; k < s.x.size(); ++k)
    r.expect(on_map(s.span, resolution_m, double{s.x[k]}, double{s.y[k]}) && std::fabs(s.theta[k]) < 10.0f,
             "particles on their maps");
}

}  // namespace

bool on_map(const TileSpan& span, double resolution_m, double x_m, double y_m) {
  const double tile_m = kTileCells * resolution_m;
  const auto within = [&](double v, std::int32_t first, std::int32_t size) {
    return size == 0 ? v == 0.0 : v >= first * tile_m && v <= (first + size) * tile_m;
  };
  return within(x_m, span.first_i, span.width) && within(y_m, span.first_j, span.height);
}

void put_pose(ByteWriter& w, const Pose& pose) {
  w.put(pose.x_m), w.put(pose.y_m), w.put(pose.theta_rad);
}
Pose get_pose(ByteReader& r) {
  Pose pose;
  pose.x_m = r.get<double>(), pose.y_m = r.get<double>(), pose.theta_rad = r.get<double>();
  r.expect(
      std::fabs(pose.x_m) <= kMostM && std::fabs(pose.y_m) <= kMostM && std::fabs(pose.theta_rad) <= kMostRad,
      "a pose");
  return pose;
}

void put_trajectory(ByteWriter& w, const Trajectory& trajectory) {
  w.put_each(trajectory, [](ByteWriter& out, const StampedPose& p) {
    out.put(p.stamp_s);
    put_pose(out, p.pose);
  });
}
Trajectory get_trajectory(ByteReader& r) {
  return r.get_each(32, [](ByteReader& in) {
    const double stamp_s = in.get<double>();
    return StampedPose{stamp_s, get_pose(in)};
  });
}

void put_beams(ByteWriter& w, const BeamTable& beams) {
  w.put_count(beams.count), w.put_count(beams.hits), w.put(beams.range_max_m);
  for (const auto array : kBeamArrays) w.put(beams.*array);
}
BeamTable get_beams(ByteReader& r) {
  BeamTable beams;
  beams.count = r.get<std::uint64_t>(), beams.hits = r.get<std::uint64_t>();
  beams.range_max_m = r.get<float>();
  r.expect(beams.hits <= beams.count && beams.count <= kMaxBeams, "a scan");
  for (const auto array : kBeamArrays) {
    beams.*array = get_floats(r, beams.count);
    for (const float v : beams.*array) r.expect(std::fabs(v) <= 1e6f, "beams of a length that can be");
  }
  measure_origins(beams);
  return beams;
}

namespace {

void put_key(ByteWriter& w, const KeyScan& key) {
  put_beams(w, key.beams);
  put_pose(w, key.pose);
  w.put_count(key.lidar);
}
KeyScan get_key(ByteReader& r, const Pose& origin) {
  constexpr double kFarthest_m = 1e4;  // cells between there and here are whole numbers of 32 bits
  KeyScan key;
  key.beams = get_beams(r);
  key.pose = get_pose(r);
  key.lidar = r.get<std::uint64_t>();
  const Pose from = relative(key.pose, origin);
  r.expect(std::fabs(from.x_m) <= kFarthest_m && std::fabs(from.y_m) <= kFarthest_m && key.lidar < 1000,
           "key scans near each other");
  return key;
}
/// Every count of a scan odometry, in the order of the file.
template <class State, class Visit>
void visit_odometry_counts(State& s, const Visit& visit) {
  for (auto* count : {&s.unfit_in_a_row, &s.counts.scans, &s.counts.unfit, &s.counts.far, &s.counts.new_maps})
    visit(*count);
}

}  // namespace

void put_scan_odometry(ByteWriter& w, const ScanOdometryState& s) {
  for (const Pose* p : {&s.origin, &s.pose, &s.step}) put_pose(w, *p);
  w.put(s.stamp_s), w.put(s.step_s);
  visit_odometry_counts(s, [&](const std::size_t& count) { w.put_count(count); });
  w.put_each(s.keys, put_key);
}
ScanOdometryState get_scan_odometry(ByteReader& r) {
  ScanOdometryState s;
  for (Pose* p : {&s.origin, &s.pose, &s.step}) *p = get_pose(r);
  s.stamp_s = r.get<double>(), s.step_s = r.get<double>();
  r.expect(std::isfinite(s.stamp_s) && s.step_s >= 0.0 && s.step_s < 1e6, "times of scans");
  visit_odometry_counts(s, [&](std::size_t& count) { count = r.get<std::uint64_t>(); });
  s.keys = r.get_each(124, [&](ByteReader& in) { return get_key(in, s.origin); });
  return s;
}

void put_tile(ByteWriter& w, const Tile& tile) {
  w.put_all(tile.cell, kCells);
}
Tile get_tile(ByteReader& r) {
  Tile tile;
  r.get_all(tile.cell, kCells);
  set_occupied(tile);
  return tile;
}

void put_backend(ByteWriter& w, const SlamBackend& backend) {
  SlamSnapshot s = backend.save();
  for (const auto* values : {&s.x, &s.y, &s.theta, &s.log_weight, &s.likelihood}) w.put(*values);
  w.put_bool(s.empty);
  for (const std::int32_t v : {s.span.first_i, s.span.first_j, s.span.width, s.span.height}) w.put(v);
  const std::vector<std::uint32_t> ids = tiles_named(s.table);
  rename(s.table, ids, places(ids.size()));
  w.put(s.table);
  w.put_count(ids.size());
  std::vector<Tile> tiles(kTilesAtOnce);
  in_batches(ids, [&](const std::vector<std::uint32_t>& batch) {
    backend.read_tiles(batch, tiles.data());
    for (std::size_t k = 0; k < batch.size(); ++k) put_tile(w, tiles[k]);
  });
}

const SlamStep& get_backend(ByteReader& r, SlamBackend& backend, const SlamConfig& config) {
  const auto count = static_cast<std::size_t>(config.particles);
  SlamSnapshot s;
  for (auto* values : {&s.x, &s.y, &s.theta, &s.log_weight, &s.likelihood}) *values = get_floats(r, count);
  s.empty = r.get_bool();
  s.span = get_span(r);
  check_poses(r, s, config.resolution);
  s.table = r.get_vector<std::uint32_t>();
  r.expect(s.table.size() % count == 0 && s.table.size() / count == s.span.size(),
           "a table for every particle");
  const std::size_t tiles = r.get_count(kCells * sizeof(CellWord));
  r.expect(std::all_of(s.table.begin(), s.table.end(), [&](std::uint32_t id) { return id <= tiles; }),
           "all tiles that the tables name");
  const std::vector<std::uint32_t> ids = backend.free_tiles(tiles);
  std::vector<Tile> memory(kTilesAtOnce);
  in_batches(ids, [&](const std::vector<std::uint32_t>& batch) {
    for (std::size_t k = 0; k < batch.size(); ++k) memory[k] = get_tile(r);
    backend.write_tiles(batch, memory.data());
  });
  rename(s.table, places(tiles), ids);
  return backend.load(s);
}

}  // namespace parloc
