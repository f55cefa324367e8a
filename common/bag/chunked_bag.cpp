#include "common/bag/chunked_bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace parloc {

namespace {
constexpr std::size_t kPieceBytes = std::size_t{8} << 20;   // of a chunk, unpacked at a time
constexpr std::size_t kMostBytes = std::size_t{16} << 20;   // of all chunks that are open
constexpr std::size_t kMostEntries = std::size_t{1} << 18;  // of a piece
constexpr std::size_t kMostMessages = 20;                   // of faults
}  // namespace

/// A chunk that is being given out. It has a message to give, always.
struct ChunkedBag::Cursor {
  std::size_t chunk = 0;
  std::unique_ptr<ChunkRecords> records;  ///< Null once all are read.
  bool whole = true;                      ///< All of the chunk is in this piece.
  bool forgotten = false;                 ///< The bytes had to make room.
  ChunkMessages messages;
  std::size_t next = 0;  ///< Index into the entries.

  std::int64_t stamp_ns() const { return messages.entries[next].stamp_ns; }
};

ChunkedBag::ChunkedBag(std::unique_ptr<BagFile> file) : file_(std::move(file)) {}
ChunkedBag::~ChunkedBag() = default;

std::int64_t ChunkedBag::first_stamp_ns() const {
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
  for (const BagChunk& chunk : chunks_) first_ns = std::min(first_ns, chunk.first_ns);
  return first_ns;
}

void ChunkedBag::select(const std::vector<bool>& topics) {
  wanted_ = topics;
  cursors_.clear();
  given_ = nullptr;
  next_chunk_ = 0;
  order_.resize(chunks_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t a, std::size_t b) { return chunks_[a].first_ns < chunks_[b].first_ns; });
}

double ChunkedBag::progress() const {
  return order_.empty() ? 1.0 : static_cast<double>(next_chunk_) / static_cast<double>(order_.size());
}

std::size_t ChunkedBag::add_topic(BagTopic topic) {
  for (std::size_t k = 0; k < topics_.size(); ++k) {
    const BagTopic& known = topics_[k];
    if (known.name == topic.name && known.type == topic.type && known.encoding == topic.encoding) return k;
  }
  topics_.push_back(std::move(topic));
  counts_.push_back(0);
  return topics_.size() - 1;
}

void ChunkedBag::count_fault(std::uint64_t offset, const std::string& what) {
  if (!faulty_places_.insert(offset).second) return;
  ++faults_.count;
  if (faults_.messages.size() < kMostMessages)
    faults_.messages.push_back(fmt::format("{}: at byte {}: {}", file_->path(), offset, what));
}

bool ChunkedBag::take_message(ByteStream& in, std::size_t topic, std::int64_t stamp_ns, std::uint64_t size,
                              ChunkMessages& messages) {
  if (looked_at_ != nullptr) {
    looked_at_->first_ns = std::min(looked_at_->first_ns, stamp_ns);
    looked_at_->last_ns = std::max(looked_at_->last_ns, stamp_ns);
    if (topic != kNoTopic) ++counts_[topic];
  }
  if (!wanted(topic)) {
    in.skip(size);
    return false;
  }
  const std::size_t most = longest_message(topics_[topic]), offset = messages.bytes.size();
  if (size > most) throw Damage{fmt::format("a message of {} bytes: expected at most {}", size, most)};
  try {
    in.append_to(messages.bytes, size);
  } catch (const Damage&) {
    messages.bytes.resize(offset);
    throw;
  }
  messages.entries.push_back({stamp_ns, topic, offset, static_cast<std::size_t>(size)});
  return true;
}

void ChunkedBag::look_through() {
  std::fill(counts_.begin(), counts_.end(), 0);
  for (BagChunk& chunk : chunks_) {
    looked_at_ = &chunk;
    chunk.first_ns = std::numeric_limits<std::int64_t>::max();
    chunk.last_ns = std::numeric_limits<std::int64_t>::min();
    try {
      const std::unique_ptr<ChunkRecords> records = open_chunk(chunk);
      for (ChunkMessages none; records->next(none);) continue;
    } catch (const Damage& damage) {
      count_fault(chunk.offset, damage.what);
    }
  }
  looked_at_ = nullptr;
  counted_ = true;
}

void ChunkedBag::add_count(std::size_t topic, std::uint64_t messages) {
  counted_ = true;
  counts_[topic] += messages;
}

// The next piece of the cursor's chunk, in the order of its stamps; false if there is none.
bool ChunkedBag::refill(Cursor& cursor) {
  cursor.messages.entries.clear();
  cursor.messages.bytes.clear();
  cursor.next = 0;
  cursor.forgotten = false;
  if (cursor.records == nullptr) return false;
  try {
    while (cursor.records->next(cursor.messages)) {
      if (cursor.messages.bytes.size() < kPieceBytes && cursor.messages.entries.size() < kMostEntries)
        continue;
      cursor.whole = false;
      break;
    }
    if (cursor.messages.bytes.size() < kPieceBytes && cursor.messages.entries.size() < kMostEntries)
      cursor.records.reset();
  } catch (const Damage& damage) {
    count_fault(chunks_[cursor.chunk].offset, damage.what);
    cursor.records.reset();
    if (damage.all) cursor.messages.entries.clear();
  }
  std::stable_sort(cursor.messages.entries.begin(), cursor.messages.entries.end(),
                   [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
  return !cursor.messages.entries.empty();
}

void ChunkedBag::open_next_chunk() {
  auto cursor = std::make_unique<Cursor>();
  cursor->messages = std::exchange(spare_, {});
  cursor->chunk = order_[next_chunk_++];
  try {
    cursor->records = open_chunk(chunks_[cursor->chunk]);
  } catch (const Damage& damage) {
    count_fault(chunks_[cursor->chunk].offset, damage.what);
  }
  if (!refill(*cursor)) {
    spare_ = std::move(cursor->messages);
    return;
  }
  make_room(cursor->messages.bytes.size());
  cursors_.push_back(std::move(cursor));
}

// Chunks whose times overlap are open together. Where they are very many, most have to be unpacked again.
void ChunkedBag::make_room(std::size_t bytes) {
  for (const auto& cursor : cursors_) bytes += cursor->messages.bytes.size();
  if (bytes <= kMostBytes) return;
  for (const auto& cursor : cursors_) {
    if (!cursor->whole || cursor->records != nullptr) continue;
    std::string().swap(cursor->messages.bytes);
    cursor->forgotten = true;
  }
}

bool ChunkedBag::unpack_again(Cursor& cursor) {
  const std::size_t next = cursor.next;
  try {
    cursor.records = open_chunk(chunks_[cursor.chunk]);
  } catch (const Damage& damage) {
    count_fault(chunks_[cursor.chunk].offset, damage.what);
  }
  if (!refill(cursor) || cursor.messages.entries.size() <= next) return false;
  cursor.next = next;
  return true;
}

std::size_t ChunkedBag::earliest() const {
  std::size_t best = cursors_.size();
  for (std::size_t k = 0; k < cursors_.size(); ++k)
    if (best == cursors_.size() || cursors_[k]->stamp_ns() < cursors_[best]->stamp_ns()) best = k;
  return best;
}

// Past the message that was given out last.
void ChunkedBag::advance() {
  Cursor* const cursor = std::exchange(given_, nullptr);
  if (cursor == nullptr || ++cursor->next < cursor->messages.entries.size() || refill(*cursor)) return;
  spare_ = std::move(cursor->messages);
  std::erase_if(cursors_, [&](const auto& other) { return other.get() == cursor; });
}

bool ChunkedBag::next(BagMessage& message) {
  advance();
  for (;;) {
    const std::size_t at = earliest();
    if (next_chunk_ < order_.size() &&
        (at == cursors_.size() || chunks_[order_[next_chunk_]].first_ns <= cursors_[at]->stamp_ns())) {
      open_next_chunk();
      continue;
    }
    if (at == cursors_.size()) return false;
    Cursor& cursor = *cursors_[at];
    if (cursor.forgotten) {
      make_room(kPieceBytes);
      if (!unpack_again(cursor)) {
        cursors_.erase(cursors_.begin() + static_cast<std::ptrdiff_t>(at));
        continue;
      }
    }
    const ChunkMessages::Entry& entry = cursor.messages.entries[cursor.next];
    message = {entry.topic, entry.stamp_ns,
               std::string_view(cursor.messages.bytes).substr(entry.offset, entry.size)};
    given_ = &cursor;
    return true;
  }
}

}  // namespace parloc
