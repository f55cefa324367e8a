// For places larger than memory: what is far from the robot is handed over to one map for all particles, the
// most likely one's, and given back when the robot comes near again. Only where slam.memory_mib asks for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/slam/slam_backend.h"

namespace parloc {

class ByteReader;
class ByteWriter;

class SubMaps {
 public:
  explicit SubMaps(const SlamConfig& config);

  /// To be called before a step, in which the robot goes `travel_m` by its odometry: what it may see then
  /// becomes part of every particle's map again, shared until one of them writes.
  void give_back(SlamBackend& backend, double travel_m);
  /// SlamBackend::mark(), after which there is room for what write() takes: if need be, what is far is handed
  /// over. Throws Error{config} if what is near is too much already.
  void make_room(SlamBackend& backend);

  /// That a backend may use (SlamBackend::move).
  std::size_t most_tiles() const { return most_tiles_ > 0 ? most_tiles_ : kNoTileLimit; }
  std::size_t places() const { return tile_.size(); }  ///< Handed over now.
  /// Puts them where they are.
  void add_to(SlamCells& cells) const;

  void save(ByteWriter& w) const;
  /// `span`: what the backend's tables cover. Throws Error{input}.
  void load(ByteReader& r, const TileSpan& span);

 private:
  using Place = std::pair<std::int32_t, std::int32_t>;  // tile's column and row from the map's origin

  bool too_many(std::size_t tiles) const { return most_tiles_ > 0 && tiles > most_tiles_; }
  void hand_over(SlamBackend& backend, SlamSnapshot& s, double reach_m);
  void restore(SlamBackend& backend, SlamSnapshot& s, const std::vector<Place>& places);

  SlamConfig config_;
  double reach_m_;          ///< Of a scan from where a particle is before it is matched.
  std::size_t most_tiles_;  ///< 0: no limit.
  std::map<Place, Tile> tile_;
};

}  // namespace parloc
