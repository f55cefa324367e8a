#include <utility>

#include "cpu/slam_stages.h"

namespace parloc::cpu {

TileStore::TileStore() {
  make_room(0);
  refs_[kNoTile] = 1;  // never free
  chunk_[0][kNoTile] = Tile{};
}

void TileStore::make_room(std::size_t more) {
  while (refs_.size() < used_ + more || refs_.empty()) {
    auto chunk = std::make_unique_for_overwrite<Tile[]>(kChunkTiles);
    refs_.reserve(refs_.size() + kChunkTiles);
    chunk_.reserve(chunk_.size() + 1);
    memory_.push_back(std::move(chunk));
    chunk_.push_back(memory_.back().get());
    refs_.resize(refs_.size() + kChunkTiles, 0);
  }
}

void TileStore::set_refs(std::vector<std::uint32_t> refs) {
  used_ = 0;
  for (const std::uint32_t r : refs) used_ += r > 0 ? 1 : 0;
  refs_ = std::move(refs);
}

}  // namespace parloc::cpu
