#include <algorithm>

#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

TileStore::TileStore(Queue& queue) {
  make_room(1, queue);
  const std::vector<Tile> empty(1);
  copy_down(memory_[0]->data(), empty.data(), sizeof(Tile), queue);
  const std::uint32_t used = 1;  // never free
  copy_down(refs_.data(), &used, sizeof used, queue);
  freed_.from_host({0}, queue);
  queue.wait();
}

void TileStore::read(const std::vector<std::uint32_t>& ids, Tile* to, const Queue& queue) const {
  for (const std::uint32_t id : ids)
    copy_up(to++, memory_[id >> kChunkShift]->data() + (id & (kChunkTiles - 1)), sizeof(Tile), queue);
  queue.wait();
}

void TileStore::write(const std::vector<std::uint32_t>& ids, const Tile* from, Queue& queue) {
  for (const std::uint32_t id : ids)
    copy_down(memory_[id >> kChunkShift]->data() + (id & (kChunkTiles - 1)), from++, sizeof(Tile), queue);
  queue.wait();
}

void TileStore::set_references(const std::vector<std::uint32_t>& refs, Queue& queue) {
  taken_ = refs.size() - static_cast<std::size_t>(std::count(refs.begin(), refs.end(), 0u));
  copy_down(refs_.data(), refs.data(), refs.size() * sizeof(std::uint32_t), queue);
  freed_.from_host({0}, queue);
  queue.wait();
}

void TileStore::make_room(std::size_t tiles, Queue& queue) {
  if (tiles <= capacity()) return;
  std::vector<std::unique_ptr<DeviceBuffer<Tile>>> more;
  while (capacity() + more.size() * kChunkTiles < tiles) {
    more.push_back(std::make_unique<DeviceBuffer<Tile>>());
    more.back()->reserve(kChunkTiles);
  }
  const std::size_t before = capacity(), chunks = memory_.size() + more.size();
  chunk_.grow(2 * chunks, queue);
  refs_.grow(chunks * kChunkTiles, queue);
  for (auto& m : more) memory_.push_back(std::move(m));
  std::vector<Tile*> pointers;
  for (const auto& m : memory_) pointers.push_back(m->data());
  copy_down(chunk_.data(), pointers.data(), pointers.size() * sizeof(Tile*), queue);
  const std::vector<std::uint32_t> none(capacity() - before, 0);
  copy_down(refs_.data() + before, none.data(), none.size() * sizeof(std::uint32_t), queue);
  queue.wait();
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
