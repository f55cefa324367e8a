// A backend of grid SLAM owns particles, tables and tiles in its memory and runs the stages on them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/filter/filter_backend.h"
#include "common/slam/matching/map_tables.h"
#include "common/slam/matching/scan_matcher.h"
#include "common/slam/slam_stages.h"

namespace parloc {

struct SlamBackendConfig {
  SlamConfig slam;
  int threads = 0;  ///< CPU: 0 is all cores.
  int device = 0;   ///< CUDA: index of the device.
};

constexpr std::size_t kNoTileLimit = static_cast<std::size_t>(-1);

/// What a step leaves, by slot.
struct SlamStep {
  std::vector<float> x, y, theta;       ///< After resampling, map frame.
  std::vector<float> likelihood;        ///< Sum of log-weights over the whole path here.
  std::vector<std::uint32_t> ancestor;  ///< Slot before resampling.
  StepState state;
  std::size_t tiles = 0;        ///< In use by all particles.
  std::size_t table_bytes = 0;  ///< Of all tables.
};

/// All that a backend has between two steps but the tiles themselves, in host memory.
struct SlamSnapshot {
  std::vector<float> x, y, theta, log_weight, likelihood;  ///< By slot, as SlamStep has them.
  bool empty = true;                                       ///< No map has a cell yet.
  TileSpan span;
  std::vector<std::uint32_t> table;  ///< [N][span.size()]
};

class SlamBackend {
 public:
  virtual ~SlamBackend() = default;
  virtual std::string name() const = 0;
  /// All particles at the origin with empty maps.
  virtual void start() = 0;
  /// A step in three parts. Moves all particles by odometry and scan, resamples, and writes the scan into all
  /// maps if then no more than `most_tiles` are in use; the host waits once, but for a map that grows. Throws
  /// Error{backend} without memory for it, Error{input} for poses that no map can hold: nothing has changed
  /// then.
  virtual void move(const MotionStep& motion, RandomKey key, const BeamTable& scan,
                    std::size_t most_tiles) = 0;
  /// How many tiles there must be room for in write(), those in use included; any number of times.
  virtual std::size_t mark() = 0;
  /// Writes the scan of move() into all maps, after mark(), if it has not been. Throws Error{backend} without
  /// memory for it; it is as before mark() then.
  virtual const SlamStep& write() = 0;
  /// All three.
  const SlamStep& step(const MotionStep& motion, RandomKey key, const BeamTable& scan) {
    move(motion, key, scan, kNoTileLimit);
    return write();
  }
  virtual SlamCells map_of(std::size_t particle) const = 0;

  virtual SlamSnapshot save() const = 0;
  /// Goes on from there, or from what was made of it: tiles that no table names any more are free.
  virtual const SlamStep& load(const SlamSnapshot& snapshot) = 0;
  /// So many that no table names, to be written and then named by load().
  virtual std::vector<std::uint32_t> free_tiles(std::size_t count) = 0;
  virtual void write_tiles(const std::vector<std::uint32_t>& ids, const Tile* from) = 0;
  virtual void read_tiles(const std::vector<std::uint32_t>& ids, Tile* to) const = 0;
};

/// Rules of a configuration; the scan's and the step's part is left open.
ProposeRules bind_propose_rules(const SlamConfig& config);
MatcherRules bind_matcher_rules(const SlamConfig& config);
DrawRules bind_draw_rules(const SlamConfig& config);
/// The part of one step; `rules.motion` and `rules.key` are given. `empty`: no map has a cell yet.
void bind_scan(ProposeRules& rules, const BeamTable& scan, bool empty);
/// values[j] of slot j's ancestor.
void inherit(std::vector<float>& values, const std::vector<std::uint32_t>& ancestor);
/// Defined in cpu/engines.cpp and cuda/engines.cu. Throw as make_cpu_filter_backend and
/// make_cuda_filter_backend.
std::unique_ptr<SlamBackend> make_cpu_slam_backend(const SlamBackendConfig& config);
std::unique_ptr<SlamBackend> make_cuda_slam_backend(const SlamBackendConfig& config);
/// As make_filter_backend.
std::unique_ptr<SlamBackend> make_slam_backend(BackendChoice choice, const SlamBackendConfig& config,
                                               std::string& why);

}  // namespace parloc
