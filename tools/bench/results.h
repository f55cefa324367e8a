// What a benchmark has measured, and on what.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/steps/measure.h"
#include "tools/bench/steps/rig.h"
#include "tools/bench/steps/variants.h"
#include "tools/report/machine/machine.h"
#include "tools/report/machine/statistics.h"

namespace parloc::tools::bench {

enum class Sweep { tables, particles, beams, threads, peers };
inline constexpr const char* kSweepNames[] = {"tables", "particles", "beams", "threads", "peers"};

/// Where a time was taken. Scene and cloud by name.
struct Place {
  std::string scene, cloud;
  bool operator==(const Place&) const = default;
};

/// One filter step of one size.
struct Row {
  Sweep sweep = Sweep::tables;
  Place place;
  std::size_t variant = 0;  ///< Index into Results::variants.
  std::int64_t particles = 0;
  int beams = 0;
  TimeSummary time;
  std::optional<StageSeconds> stages;  ///< Medians; in the sweeps of --scale.

  double rays_per_s() const { return static_cast<double>(particles) * beams / time.median_s; }
};

/// The largest number of particles whose median step is within a budget.
struct Largest {
  Place place;
  std::size_t variant = 0;
  int beams = 0;
  double budget_s = 0.0;
  std::int64_t particles = 0;  ///< 0: not even the smallest that was tried.
  std::int64_t too_many = 0;   ///< The smallest that was found not to fit; 0: none was, see `limit`.
  std::string limit;           ///< What ended the search at `particles` then.
  double median_s = 0.0, p99_s = 0.0;
};

struct Skipped {
  std::string what, why;
};

struct SceneFacts {
  std::string name, what;
};

struct Results {
  bool scale = false;  ///< Else the published tables.
  bool quick = false;
  bool interrupted = false;
  bool failed = false;  ///< Something broke that ought to work: a device in the middle of a step.
  std::string command, date;
  Machine machine;
  TimingRules rules;
  std::vector<SceneFacts> scenes;
  std::vector<Variant> variants;
  std::vector<std::string> backends;  ///< As each variant's backend calls itself; "" before it has run.
  std::vector<Row> rows;
  std::vector<Largest> largest;
  std::vector<Skipped> skipped;
  std::vector<std::string> notes;

  /// Index of a variant, which is added if it is new.
  std::size_t index_of(const Variant& variant);
  /// The row of that size; null if it was not measured.
  const Row* find(Sweep sweep, const Place& place, std::size_t variant, std::int64_t particles,
                  int beams) const;
  /// Scenes and clouds that have rows (or largest sizes), in the order of measuring.
  std::vector<Place> places() const;
  /// Variants with rows there, in the order of `variants`.
  std::vector<std::size_t> variants_of(Sweep sweep, const Place& place) const;
};

/// "no_hit, tracking, 4000 x 200".
std::string name_of(const Place& place, std::int64_t particles, int beams);

/// Skipped rows in few lines: rows of the same reason together.
std::vector<std::string> skipped_lines(const std::vector<Skipped>& skipped);

}  // namespace parloc::tools::bench
