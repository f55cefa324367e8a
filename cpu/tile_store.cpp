#include <utility>

#include "common/slam/matching/map_tables.h"
#include "cpu/slam_stages.h"

namespace parloc::cpu {

TileStore::TileStore(Queue& queue) {
  make_room(1, queue);
  refs_[kNoTile] = 1;  // never free
  chunk_[0][kNoTile] = Tile{};
}

void TileStore::make_room(std::size_t tiles, Queue&) {
  while (refs_.size() < tiles) {
    auto chunk = std::make_unique_for_overwrite<Tile[]>(kChunkTiles);
    refs_.reserve(refs_.size() + kChunkTiles);
    chunk_.reserve(chunk_.size() + 1);
    memory_.push_back(std::move(chunk));
    chunk_.push_back(memory_.back().get());
    refs_.resize(refs_.size() + kChunkTiles, 0);
  }
}

void TileStore::read(const std::vector<std::uint32_t>& ids, Tile* to, const Queue&) const {
  for (const std::uint32_t id : ids) *to++ = pool().at(id);
}

void TileStore::write(const std::vector<std::uint32_t>& ids, const Tile* from, Queue&) {
  for (const std::uint32_t id : ids) pool().at(id) = *from++;
}

std::vector<std::uint32_t> TileStore::first_free(std::size_t count, const Queue&) const {
  return parloc::first_free(refs_.data(), count);
}

void TileStore::set_references(std::vector<std::uint32_t> refs, Queue&) {
  used_ = 0;
  for (const std::uint32_t r : refs) used_ += r > 0 ? 1 : 0;
  refs_ = std::move(refs);
}

}  // namespace parloc::cpu
