// The times that Paz et al. 2012 published: what `parloc bench` is compared with.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "common/model/sensor_config.h"

namespace parloc::tools::bench {

inline constexpr std::array<std::int64_t, 5> kPublishedParticles{500, 1000, 2000, 3000, 4000};
inline constexpr std::array<int, 3> kPublishedBeams{50, 100, 200};

/// The paper's criterion of real time: a filter step within this.
inline constexpr double kBudget_s = 0.040;

/// Times of one filter step, in the worst case: no obstacle within range of any ray.
struct PublishedTable {
  const char* key;      ///< For files: "single_core", "gtx560", "opteron".
  const char* machine;  ///< For people.
  /// [particles][beams], as kPublishedParticles and kPublishedBeams have them.
  std::array<std::array<double, kPublishedBeams.size()>, kPublishedParticles.size()> seconds;
};

const std::array<PublishedTable, 3>& published_tables();

/// What another program takes for the step that `parloc bench` measures as a peer row: hall with obstacles,
/// tracking, kPeerParticles x kPeerBeams, nothing given up early.
struct PeerTime {
  const char* program;
  SensorModel model;
  int threads;
  double seconds;
};
inline constexpr std::int64_t kPeerParticles = 4000;
inline constexpr int kPeerBeams = 200;
inline constexpr const char* kPeerScene = "hall_obstacles";
/// Where the times of the peers were measured, all of them in one run.
inline constexpr const char* kPeerMachine = "2 cores of a Xeon with AVX-512";
std::span<const PeerTime> peer_times();

/// Empty for a size that is not in the tables.
std::optional<double> published_seconds(const PublishedTable& table, std::int64_t particles, int beams);

}  // namespace parloc::tools::bench
