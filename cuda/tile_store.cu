#include <utility>

#include "cuda/lists.h"
#include "cuda/slam_stages.h"

namespace parloc::PARLOC_CUDA_NAMESPACE {

TileStore::TileStore(Queue& queue) {
  make_room(1, queue);
  const std::vector<Tile> empty(1);
  copy_down(tile(kNoTile), empty.data(), sizeof(Tile), queue);
  queue.wait();
  fill(refs_.data(), 1, 1, queue);  // never free
  used_.from_host({1}, queue);
}

void TileStore::read(const std::vector<std::uint32_t>& ids, Tile* to, const Queue& queue) const {
  for (const std::uint32_t id : ids) copy_up(to++, tile(id), sizeof(Tile), queue);
  queue.wait();
}

void TileStore::write(const std::vector<std::uint32_t>& ids, const Tile* from, Queue& queue) {
  for (const std::uint32_t id : ids) copy_down(tile(id), from++, sizeof(Tile), queue);
  queue.wait();
}

void TileStore::set_references(const std::vector<std::uint32_t>& refs, Queue& queue) {
  refs_.from_host(refs, queue);
  used_.from_host({capacity() - count_zeros(refs_.data(), capacity(), queue)}, queue);
}

std::vector<std::uint32_t> TileStore::first_free(std::size_t count, const Queue& queue) const {
  list_zeros(refs_.data(), capacity(), ids_.data(), queue);
  return ids_.to_host(count, queue);
}

void TileStore::make_room(std::size_t tiles, Queue& queue) {
  if (tiles <= capacity()) return;
  const std::size_t before = capacity(), chunks = (tiles + kChunkTiles - 1) / kChunkTiles;
  DeviceBuffer<Tile> more;
  more.reserve(chunks * kChunkTiles - before);
  DeviceBuffer<Tile*> chunk;
  chunk.reserve(chunks);
  DeviceBuffer<std::uint32_t> refs;
  refs.reserve(chunks * kChunkTiles);
  used_.reserve(1);
  queue.scratch.lists.reserve(list_scratch_bytes(chunks * kChunkTiles));
  free_.reserve(chunks * kChunkTiles), before_.reserve(sum_blocks(chunks * kChunkTiles));
  ids_.reserve(chunks * kChunkTiles), fresh_.reserve(chunks * kChunkTiles);
  std::vector<Tile*> first = first_;
  for (std::size_t k = 0; first.size() < chunks; ++k) first.push_back(more.data() + k * kChunkTiles);
  memory_.reserve(memory_.size() + 1);

  if (before > 0) copy_across(refs.data(), refs_.data(), before * sizeof(std::uint32_t), queue);
  fill(refs.data() + before, chunks * kChunkTiles - before, 0, queue);
  chunk.from_host(first, queue);  // waits
  memory_.push_back(std::move(more));
  first_.swap(first);
  chunk_.swap(chunk);
  refs_.swap(refs);
}

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
