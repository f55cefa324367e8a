#include "common/slam/grid_slam.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/error.h"
#include "common/file/bytes.h"
#include "common/file/output_file.h"
#include "common/filter/steps/step_front_end.h"
#include "common/math/sha256.h"
#include "common/slam/checkpoint_values.h"
#include "common/slam/loops/close_loops.h"
#include "common/slam/path_tree.h"
#include "common/slam/scan_odometry.h"
#include "common/slam/slam_backend.h"
#include "common/slam/slam_settings.h"
#include "common/slam/sub_maps.h"

namespace parloc {
namespace {

/// A scan, and which of the steps was the last one then.
struct Moment {
  double stamp_s;
  Pose odometry;
  std::size_t step;
  bool counted;
};

void put_moment(ByteWriter& w, const Moment& m) {
  w.put(m.stamp_s);
  put_pose(w, m.odometry);
  w.put_count(m.step);
  w.put_bool(m.counted);
}
Moment get_moment(ByteReader& r) {
  const auto stamp_s = r.get<double>();
  const Pose odometry = get_pose(r);
  const std::size_t step = r.get<std::uint64_t>();
  return {stamp_s, odometry, step, r.get_bool()};
}
void put_record(ByteWriter& w, const SlamRecord& record) {
  w.put(record.stamp_s), w.put(record.n_eff);
  w.put_bool(record.resampled);
  w.put_count(record.tiles);
  w.put_count(record.handed_over);
}
SlamRecord get_record(ByteReader& r) {
  const auto stamp_s = r.get<double>(), n_eff = r.get<double>();
  const bool resampled = r.get_bool();
  const std::size_t tiles = r.get<std::uint64_t>();
  return {stamp_s, n_eff, resampled, tiles, static_cast<std::size_t>(r.get<std::uint64_t>())};
}

/// All that the tables cover, row by row; cells without a tile are zero.
void add_cells(Sha256& sha, const SlamCells& cells) {
  const std::int32_t i0 = cells.first_i - cells.span.first_i * kTileCells;
  const std::int32_t j0 = cells.first_j - cells.span.first_j * kTileCells;
  const auto width = static_cast<std::size_t>(cells.width);
  std::vector<CellWord> row(static_cast<std::size_t>(cells.span.width) * kTileCells);
  for (std::int32_t j = 0; j < cells.span.height * kTileCells; ++j) {
    std::fill(row.begin(), row.end(), 0);
    if (j >= j0 && j < j0 + cells.height)
      std::copy_n(cells.cell.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(j - j0) * width),
                  width, row.begin() + i0);
    sha.add(row.data(), row.size() * sizeof(CellWord));
  }
}

std::string digest_of(const Trajectory& trajectory, const SlamCells& cells) {
  Sha256 sha;
  for (const StampedPose& p : trajectory)
    for (const double v : {p.pose.x_m, p.pose.y_m, p.pose.theta_rad}) sha.add(v);
  add_cells(sha, cells);
  return sha.hex();
}

void expect_a_scan(const std::vector<SlamRecord>& records) {
  if (records.empty()) throw Error(ErrorKind::input, "slam: no scan was taken in, there is no map");
}

}  // namespace

struct GridSlam::State {
  explicit State(const GridSlamConfig& c)
      : config(c), front_end(config), paths(static_cast<std::size_t>(c.slam.particles)), sub_maps(c.slam) {}

  GridSlamConfig config;
  std::unique_ptr<SlamBackend> backend;
  StepFrontEnd front_end;  ///< Its odometry is that of the last scan that counted.
  BeamTable beams;
  std::optional<ScanOdometry> scan_odometry;  ///< In place of the recorded one.
  std::vector<Moment> moments;
  std::vector<Pose> odometry_of;  ///< By step.
  std::vector<BeamTable> scans;   ///< By step, only where loops are to be closed.
  std::vector<SlamRecord> records;
  PathTree paths;
  SubMaps sub_maps;
  const SlamStep* last = nullptr;
  std::optional<ClosedPath> closed;  ///< Of the steps so far, once it was asked for.

  bool far_enough(const Pose& now) const { return front_end.moved_enough(front_end.odometry(), now); }
  /// Puts the scan's own odometry, if so set, in place of the recorded one; whether the scan is one to take
  /// in.
  bool next_odometry(Pose& now, const Scan& scan) {
    if (!scan_odometry) return far_enough(now) && take_in(scan);
    const bool enough = take_in(scan);
    now = scan_odometry->step(scan.stamp_s, beams, front_end.lidar_of(scan), enough);
    front_end.track().add(scan.stamp_s, now);  // of its own: neither late nor out of scale
    return enough && far_enough(now);
  }
  /// What the sensor models of a filter on a map need of a beam is not read here.
  bool take_in(const Scan& scan) {
    return front_end.take(scan, SensorConfig{}, config.slam.resolution, beams) &&
           beams.hits >= static_cast<std::size_t>(config.scan.min_beams);
  }
  Pose pose_at(const Moment& m, const std::vector<Pose>& path) const;
  SlamCells cells_of(std::size_t particle) const;
  std::unique_ptr<ScanMatcher> matcher() const {
    return make_scan_matcher(config.backend,
                             {bind_matcher_rules(config.slam), config.threads, config.device});
  }
  std::size_t best() const;
  /// By step, the best particle's poses.
  std::vector<Pose> path() const { return paths.path(best()); }
  /// The same with loops closed.
  const ClosedPath& closed_path(const std::function<void(double fraction)>& watch = {});
  Trajectory along(const std::vector<Pose>& path) const;
  /// The map to show, of the best particle or with loops closed.
  SlamCells cells();
  GridMap cropped(const SlamCells& cells) const;
  /// All members above but config, and what follows from the others. The order is that of the file.
  void save(ByteWriter& w) const;
  void load(ByteReader& r);
};

GridSlam::GridSlam(const GridSlamConfig& config) : state_(std::make_unique<State>(config)) {
  validate(config);
  std::string why;
  state_->backend = make_slam_backend(config.backend, {config.slam, config.threads, config.device}, why);
  if (config.slam.odometry == SlamOdometry::scans) state_->scan_odometry.emplace(state_->matcher());
}
GridSlam::GridSlam(SlamCheckpoint checkpoint) : GridSlam(checkpoint.config) {
  const std::string change = config_difference(checkpoint.saved_config_, checkpoint.config);
  if (!change.empty()) throw Error(ErrorKind::config, checkpoint.name() + ": " + change);
  state_->load(*checkpoint.rest_);
}
GridSlam::~GridSlam() = default;

void GridSlam::save(const std::string& path, const std::string& own) const {
  FileReplacement file(path);
  ByteWriter w([&](const void* data, std::size_t size) { file.write(data, size); });
  put_checkpoint_begin(w);
  w.put_text(settings_to_yaml(settings_of(state_->config)));
  w.put_text(own);
  state_->save(w);
  put_checkpoint_end(w);
  file.commit();
}

void GridSlam::State::save(ByteWriter& w) const {
  put_backend(w, *backend);
  put_front_end(w, front_end);
  w.put_each(moments, put_moment);
  w.put_each(odometry_of, put_pose);
  w.put_each(records, put_record);
  paths.save(w);
  sub_maps.save(w);
  if (scan_odometry) put_scan_odometry(w, scan_odometry->state());
  if (config.slam.close_loops) w.put_each(scans, put_beams);
}

void GridSlam::State::load(ByteReader& r) {
  last = &get_backend(r, *backend, config.slam);
  get_front_end(r, front_end);
  moments = r.get_each(41, get_moment);
  odometry_of = r.get_each(24, get_pose);
  records = r.get_each(33, get_record);
  const TileSpan span = backend->save().span;
  paths.load(r, [&](const Pose& p) { return on_map(span, config.slam.resolution, p.x_m, p.y_m); });
  sub_maps.load(r, span);
  if (scan_odometry) scan_odometry->restore(get_scan_odometry(r));
  closed.reset();
  if (config.slam.close_loops) scans = r.get_each(84, get_beams);
  r.expect(r.left() == 0, "its end");
  const std::size_t steps = records.size();
  r.expect(odometry_of.size() == steps && paths.steps() == steps &&
               front_end.odometry().has_value() == (steps > 0) &&
               (!config.slam.close_loops || scans.size() == steps),
           "as much of everything as there were scans");
  for (const Moment& m : moments) r.expect(m.step < steps, "scans between those that counted");
  if (steps == 0) last = nullptr;
}

void GridSlam::add_odometry(double stamp_s, const Pose& odometry) {
  if (!state_->scan_odometry) state_->front_end.add_odometry(stamp_s, odometry);
}

bool GridSlam::step(const Pose& recorded, const Scan& scan) {
  State& s = *state_;
  if (s.scan_odometry || is_finite(recorded)) s.front_end.check(scan);
  if (!s.front_end.refuse(scan).empty()) return false;
  Pose odometry = recorded;
  if (!s.scan_odometry) {
    const std::optional<OdometryReading> reading = s.front_end.take_odometry(scan.stamp_s, recorded);
    if (!reading) return false;
    odometry = reading->pose;
  }
  s.front_end.note_taken(scan);
  const bool counts = s.next_odometry(odometry, scan);
  if (!counts) {
    if (s.front_end.odometry()) s.moments.push_back({scan.stamp_s, odometry, s.records.size() - 1, false});
    return false;
  }
  Movement movement = s.front_end.move_to(odometry);
  movement.elapsed_s = 0.0;  // the pose is improved by the scan: time alone adds no noise
  const RandomKey key{s.config.seed, static_cast<std::uint32_t>(s.records.size())};
  s.sub_maps.give_back(*s.backend, std::fabs(movement.increment.trans_m));
  s.backend->move(motion_step(movement, s.config.motion), key, s.beams, s.sub_maps.most_tiles());
  s.sub_maps.make_room(*s.backend);
  s.last = &s.backend->write();
  s.odometry_of.push_back(odometry);
  if (s.config.slam.close_loops) s.scans.push_back(s.beams);
  s.closed.reset();
  s.moments.push_back({scan.stamp_s, odometry, s.records.size(), true});
  s.paths.add(poses(), s.last->ancestor);
  s.records.push_back(
      {scan.stamp_s, s.last->state.n_eff, s.last->state.resample != 0, s.last->tiles, s.sub_maps.places()});
  return true;
}

bool GridSlam::step(const Scan& scan) {
  StepFrontEnd& front_end = state_->front_end;
  front_end.check(scan);
  if (!state_->scan_odometry && front_end.refusal(scan).empty()) front_end.prepare_odometry(scan.stamp_s);
  return step(Pose{}, scan);
}

std::vector<Pose> GridSlam::poses() const {
  const State& s = *state_;
  std::vector<Pose> poses(s.last == nullptr ? 0 : s.last->x.size());
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = {s.last->x[i], s.last->y[i], s.last->theta[i]};
  return poses;
}

std::size_t GridSlam::best() const {
  return state_->best();
}
std::size_t GridSlam::State::best() const {
  const std::vector<float>& l = last->likelihood;
  return static_cast<std::size_t>(std::max_element(l.begin(), l.end()) - l.begin());
}

Pose GridSlam::State::pose_at(const Moment& m, const std::vector<Pose>& path) const {
  if (m.counted) return path[m.step];
  const Pose forward = compose(path[m.step], relative(m.odometry, odometry_of[m.step]));
  if (m.step + 1 >= path.size()) return forward;
  const Pose &before = odometry_of[m.step], &after = odometry_of[m.step + 1];
  const Pose backward = compose(path[m.step + 1], relative(m.odometry, after));
  // A radian of turning counts as a metre.
  const double to = distance_m(before, m.odometry) + turn_rad(before, m.odometry);
  const double from = distance_m(m.odometry, after) + turn_rad(m.odometry, after);
  return blend(forward, backward, to + from > 0.0 ? to / (to + from) : 0.0);
}

SlamCells GridSlam::State::cells_of(std::size_t particle) const {
  SlamCells cells = backend->map_of(particle);
  sub_maps.add_to(cells);
  return cells;
}

const ClosedPath& GridSlam::State::closed_path(const std::function<void(double fraction)>& watch) {
  if (!closed) closed = parloc::close_loops({path(), odometry_of, scans}, *matcher(), watch);
  return *closed;
}

SlamCells GridSlam::State::cells() {
  if (!config.slam.close_loops || closed_path().counts.used == 0) return cells_of(best());
  return drawn_map(scans, closed_path().path, *matcher());
}

Trajectory GridSlam::State::along(const std::vector<Pose>& path) const {
  Trajectory out;
  for (const Moment& m : moments) out.push_back({m.stamp_s, pose_at(m, path)});
  return out;
}

Trajectory GridSlam::trajectory() const {
  State& s = *state_;
  if (s.records.empty() || !s.config.slam.close_loops) return trajectory_so_far();
  return s.along(s.closed_path().path);
}
Trajectory GridSlam::trajectory_so_far() const {
  return state_->records.empty() ? Trajectory{} : state_->along(state_->path());
}

void GridSlam::close_loops(const std::function<void(double fraction)>& watch) const {
  State& s = *state_;
  if (s.config.slam.close_loops && !s.records.empty()) s.closed_path(watch);
}
std::optional<LoopCounts> GridSlam::loops() const {
  State& s = *state_;
  if (!s.config.slam.close_loops) return std::nullopt;
  return s.records.empty() ? LoopCounts{} : s.closed_path().counts;
}

GridMap GridSlam::map() const {
  expect_a_scan(state_->records);
  return state_->cropped(state_->cells());
}
GridMap GridSlam::map_so_far() const {
  expect_a_scan(state_->records);
  return state_->cropped(state_->cells_of(state_->best()));
}

GridMap GridSlam::State::cropped(const SlamCells& cells) const {
  std::int32_t i0 = cells.width, i1 = -1, j0 = cells.height, j1 = -1;
  const auto word = [&](std::int32_t i, std::int32_t j) {
    return cells.cell[static_cast<std::size_t>(j) * static_cast<std::size_t>(cells.width) +
                      static_cast<std::size_t>(i)];
  };
  for (std::int32_t j = 0; j < cells.height; ++j)
    for (std::int32_t i = 0; i < cells.width; ++i)
      if (visits_of(word(i, j)) > 0)
        i0 = std::min(i0, i), i1 = std::max(i1, i), j0 = std::min(j0, j), j1 = std::max(j1, j);
  if (i1 < 0) throw Error(ErrorKind::input, "slam: no beam ended or passed anywhere, there is no map");
  GridMap map;
  map.width = i1 - i0 + 1, map.height = j1 - j0 + 1;
  map.resolution_m = config.slam.resolution;
  map.T_map_grid = {(cells.first_i + i0) * map.resolution_m, (cells.first_j + j0) * map.resolution_m, 0.0};
  map.name = "slam";
  map.cells.reserve(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  for (std::int32_t j = j0; j <= j1; ++j)
    for (std::int32_t i = i0; i <= i1; ++i) {
      const CellWord w = word(i, j);
      const bool wall = hits_of(w) > config.slam.occupied_above * visits_of(w);
      map.cells.push_back(visits_of(w) == 0 ? Cell::unknown : wall ? Cell::occupied : Cell::free);
    }
  return map;
}

const std::vector<SlamRecord>& GridSlam::records() const {
  return state_->records;
}
std::vector<std::size_t> GridSlam::distinct_ancestors() const {
  return state_->paths.distinct();
}
SlamMemory GridSlam::memory() const {
  const State& s = *state_;
  SlamMemory memory;
  for (const SlamRecord& r : s.records)
    memory.most_tile_bytes = std::max(memory.most_tile_bytes, r.tiles * sizeof(Tile));
  memory.sub_map_bytes = s.sub_maps.places() * sizeof(Tile);
  if (!s.records.empty()) memory.tile_bytes = s.records.back().tiles * sizeof(Tile);
  if (s.last != nullptr) memory.table_bytes = s.last->table_bytes;
  return memory;
}
Trajectory GridSlam::odometry() const {
  Trajectory out;
  for (const Moment& m : state_->moments) out.push_back({m.stamp_s, m.odometry});
  return out;
}
std::optional<ScanOdometryCounts> GridSlam::scan_odometry() const {
  const State& s = *state_;
  return s.scan_odometry ? std::optional(s.scan_odometry->state().counts) : std::nullopt;
}
const std::vector<LidarUse>& GridSlam::lidars_used() const {
  return state_->front_end.lidars_used();
}
const GridSlamConfig& GridSlam::config() const {
  return state_->config;
}
std::size_t GridSlam::odometry_jumps() const {
  return state_->front_end.continuous().jumps();
}
std::size_t GridSlam::odometry_invalid() const {
  return state_->front_end.continuous().invalid();
}
std::string GridSlam::backend_name() const {
  return state_->backend->name();
}
std::string GridSlam::digest() const {
  return digest_of(trajectory(), state_->cells());
}
std::string GridSlam::digest_so_far() const {
  return digest_of(trajectory_so_far(), state_->cells_of(best()));
}

}  // namespace parloc
