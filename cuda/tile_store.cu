#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

TileStore::TileStore(Stream stream) {
  make_room(1, stream);
  const std::vector<Tile> empty(1);
  copy_down(memory_[0]->data(), empty.data(), sizeof(Tile), stream);
  const std::uint32_t used = 1;  // never free
  copy_down(refs_.data(), &used, sizeof used, stream);
  synchronise(stream);
}

void TileStore::read(const std::vector<std::uint32_t>& ids, Tile* to, Stream stream) const {
  for (const std::uint32_t id : ids)
    copy_up(to++, memory_[id >> kChunkShift]->data() + (id & (kChunkTiles - 1)), sizeof(Tile), stream);
  synchronise(stream);
}

void TileStore::write(const std::vector<std::uint32_t>& ids, const Tile* from, Stream stream) {
  for (const std::uint32_t id : ids)
    copy_down(memory_[id >> kChunkShift]->data() + (id & (kChunkTiles - 1)), from++, sizeof(Tile), stream);
  synchronise(stream);
}

void TileStore::make_room(std::size_t tiles, Stream stream) {
  if (tiles <= capacity()) return;
  std::vector<std::unique_ptr<DeviceBuffer<Tile>>> more;
  while (capacity() + more.size() * kChunkTiles < tiles) {
    more.push_back(std::make_unique<DeviceBuffer<Tile>>());
    more.back()->reserve(kChunkTiles);
  }
  const std::size_t before = capacity(), chunks = memory_.size() + more.size();
  chunk_.grow(2 * chunks, stream);
  refs_.grow(chunks * kChunkTiles, stream);
  for (auto& m : more) memory_.push_back(std::move(m));
  std::vector<Tile*> pointers;
  for (const auto& m : memory_) pointers.push_back(m->data());
  copy_down(chunk_.data(), pointers.data(), pointers.size() * sizeof(Tile*), stream);
  const std::vector<std::uint32_t> none(capacity() - before, 0);
  copy_down(refs_.data() + before, none.data(), none.size() * sizeof(std::uint32_t), stream);
  synchronise(stream);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
