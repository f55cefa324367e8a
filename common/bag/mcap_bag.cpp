#include "common/bag/mcap_bag.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "common/bag/chunked_bag.h"
#include "common/bag/mcap_format.h"
#include "common/bag/type_name.h"
#include "common/error.h"

namespace parloc {

namespace {

using namespace mcap;

constexpr std::uint64_t kMagicBytes = kMagic.size();
constexpr std::uint64_t kHeadBytes = 9;  // opcode and length
constexpr std::uint64_t kLongestDescription = std::uint64_t{16} << 20;

/// The bytes of one record, taken out field by field.
class Record {
 public:
  explicit Record(std::string_view bytes) : bytes_(bytes) {}
  template <class Number>
  Number number() {
    return little_endian<Number>(take(sizeof(Number)).data());
  }
  std::string text() { return std::string(take(number<std::uint32_t>())); }

 private:
  std::string_view take(std::size_t size) {
    if (size > bytes_.size()) throw Damage{"expected a longer record"};
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }
  std::string_view bytes_;
};

std::int64_t stamp_of(std::uint64_t ns) {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(ns, INT64_MAX));
}

/// The checksum of what goes through it.
class Checked final : public ByteStream {
 public:
  Checked(std::unique_ptr<ByteStream> stream, std::uint32_t expected)
      : stream_(std::move(stream)), expected_(expected) {}

  std::size_t read(char* to, std::size_t size) override {
    const std::size_t got = stream_->read(to, size);
    crc_ = crc32_z(crc_, reinterpret_cast<const Bytef*>(to), got);
    if (got < size && !std::exchange(told_, true) && crc_ != expected_)
      throw Damage{"wrong checksum: nothing of this chunk is used", true};
    return got;
  }

 private:
  std::unique_ptr<ByteStream> stream_;
  uLong crc_ = 0;
  std::uint32_t expected_;
  bool told_ = false;
};

class McapBag final : public ChunkedBag {
 public:
  explicit McapBag(std::unique_ptr<BagFile> file) : ChunkedBag(std::move(file)) {
    walk();
    if (!read_summary() || times_unknown_) look_through();
    select(std::vector<bool>(topics().size(), true));
  }
  std::string container() const override { return "mcap"; }

 protected:
  std::unique_ptr<ChunkRecords> open_chunk(const BagChunk& chunk) override;

 private:
  struct Records;
  void walk();
  bool ends_with_magic() const;
  void add_chunk(ByteStream& in, std::uint64_t at, std::uint64_t length);
  void add_message(std::uint64_t at, std::uint64_t size, std::int64_t stamp_ns);
  bool read_summary();
  void learn(std::uint8_t opcode, std::string_view bytes);
  void learn_counts(std::string_view bytes);

  std::map<std::uint16_t, std::string> schemas_;        ///< Names of types.
  std::map<std::uint16_t, std::size_t> channel_topic_;  ///< Index into topics().
  bool run_open_ = false;                               ///< The last chunk is one of loose messages.
  bool times_unknown_ = false;                          ///< A chunk does not say when it is of.
};

/// The records of a chunk, or of messages without one.
struct McapBag::Records final : ChunkRecords {
  Records(McapBag& bag_, std::unique_ptr<ByteStream> stream_) : bag(bag_), stream(std::move(stream_)) {}

  bool next(ChunkMessages& messages) override {
    for (;;) {
      char head[kHeadBytes];
      const std::size_t got = stream->read(head, sizeof head);
      if (got == 0) return false;
      if (got < sizeof head) throw Damage{"cut off"};
      const auto opcode = static_cast<std::uint8_t>(head[0]);
      const auto length = little_endian<std::uint64_t>(head + 1);
      if (opcode == kMessage) {
        if (take_message(length, messages)) return true;
      } else if (opcode == 0) {
        throw Damage{"expected a record"};
      } else if (opcode == kSchema || opcode == kChannel) {
        if (length > kLongestDescription) throw Damage{"expected a shorter description of a topic"};
        std::string bytes;
        stream->append_to(bytes, length);
        bag.learn(opcode, bytes);
      } else {
        stream->skip(length);
      }
    }
  }

  bool take_message(std::uint64_t length, ChunkMessages& messages) {
    constexpr std::uint64_t header_bytes = 22;
    if (length < header_bytes) throw Damage{"expected a longer message record"};
    const auto channel = stream->number<std::uint16_t>();
    stream->number<std::uint32_t>();
    const std::int64_t stamp_ns = stamp_of(stream->number<std::uint64_t>());
    stream->number<std::uint64_t>();
    const auto topic = bag.channel_topic_.find(channel);
    return bag.take_message(*stream, topic == bag.channel_topic_.end() ? kNoTopic : topic->second, stamp_ns,
                            length - header_bytes, messages);
  }

  McapBag& bag;
  std::unique_ptr<ByteStream> stream;
};

std::unique_ptr<ChunkRecords> McapBag::open_chunk(const BagChunk& chunk) {
  std::unique_ptr<ByteStream> stream =
      decompressed(chunk.compression, file_->stream(chunk.offset, chunk.packed_size));
  if (chunk.has_checksum) stream = std::make_unique<Checked>(std::move(stream), chunk.checksum);
  return std::make_unique<Records>(*this, std::move(stream));
}

void McapBag::learn(std::uint8_t opcode, std::string_view bytes) {
  Record record(bytes);
  const auto id = record.number<std::uint16_t>();
  if (opcode == kSchema) {
    schemas_.emplace(id, record.text());
    return;
  }
  const auto schema = schemas_.find(record.number<std::uint16_t>());
  const std::string name = record.text();
  const std::string encoding = record.text();
  const std::string type = schema == schemas_.end() ? "" : type_name(schema->second);
  channel_topic_.emplace(id, add_topic({name, type, encoding}));
}

// Messages, schemas, channels, attachments, metadata, chunks, first and last time; then messages by channel.
void McapBag::learn_counts(std::string_view bytes) {
  Record record(bytes);
  record.number<std::uint64_t>();
  record.number<std::uint16_t>();
  for (int k = 0; k < 4; ++k) record.number<std::uint32_t>();
  for (int k = 0; k < 2; ++k) record.number<std::uint64_t>();
  for (auto left = record.number<std::uint32_t>() / 10; left > 0; --left) {
    const auto topic = channel_topic_.find(record.number<std::uint16_t>());
    const auto messages = record.number<std::uint64_t>();
    if (topic != channel_topic_.end()) add_count(topic->second, messages);
  }
}

// All records of the data section by their heads alone: where the chunks are. Does not trust the index, which
// may be missing or wrong.
void McapBag::walk() {
  std::uint64_t at = kMagicBytes;
  bool ended = false;
  try {
    const std::unique_ptr<ByteStream> in = file_->stream(at, file_->size());
    while (!ended) {
      char head[kHeadBytes];
      const std::size_t got = in->read(head, sizeof head);
      if (got < sizeof head) break;
      const auto opcode = static_cast<std::uint8_t>(head[0]);
      const auto length = little_endian<std::uint64_t>(head + 1);
      const std::uint64_t left = file_->size() - at - kHeadBytes;
      ended = opcode == kDataEnd || opcode == kFooter;
      if (ended) break;
      if (opcode == kChunk) {
        run_open_ = false;
        add_chunk(*in, at, std::min(length, left));
        if (length > left) break;
      } else if (length > left) {
        break;
      } else if (opcode == kMessage && length >= 22) {
        in->skip(6);
        add_message(at, length + kHeadBytes, stamp_of(in->number<std::uint64_t>()));
        in->skip(length - 14);
      } else if ((opcode == kSchema || opcode == kChannel) && length <= kLongestDescription) {
        std::string bytes;
        in->append_to(bytes, length);
        learn(opcode, bytes);
      } else {
        in->skip(length);
      }
      at += kHeadBytes + length;
    }
  } catch (const Damage& damage) {
    count_fault(at, damage.what);
  }
  if (!ended) {
    count_fault(
        at, fmt::format("cut off or damaged: what is whole before is read ({} bytes in all)", file_->size()));
  } else if (!ends_with_magic()) {
    count_fault(at, "cut off behind the messages: all of them are read");
  }
}

bool McapBag::ends_with_magic() const {
  char end[kMagicBytes];
  return file_->stream(file_->size() - kMagicBytes, kMagicBytes)->read(end, kMagicBytes) == kMagicBytes &&
         std::string_view(end, kMagicBytes) == kMagic;
}

// A chunk: start and end time, unpacked size, checksum, compression, size of the records, records.
void McapBag::add_chunk(ByteStream& in, std::uint64_t at, std::uint64_t length) {
  constexpr std::uint64_t fixed_bytes = 8 + 8 + 8 + 4 + 4;
  if (length < fixed_bytes) throw Damage{"expected a longer chunk"};
  BagChunk chunk;
  chunk.first_ns = stamp_of(in.number<std::uint64_t>());
  chunk.last_ns = stamp_of(in.number<std::uint64_t>());
  in.number<std::uint64_t>();
  chunk.checksum = in.number<std::uint32_t>();
  const auto name_bytes = in.number<std::uint32_t>();
  if (name_bytes > length - fixed_bytes) throw Damage{"expected the name of a compression"};
  std::string name;
  in.append_to(name, std::min<std::uint32_t>(name_bytes, 100));
  in.skip(name_bytes - name.size());
  if (length - fixed_bytes - name_bytes < 8) throw Damage{"expected a longer chunk"};
  const auto stated = in.number<std::uint64_t>();
  const std::uint64_t there = length - fixed_bytes - name_bytes - 8;
  chunk.offset = at + kHeadBytes + fixed_bytes + name_bytes + 8;
  chunk.packed_size = std::min(stated, there);
  chunk.has_checksum = chunk.checksum != 0 && stated <= there;
  times_unknown_ = times_unknown_ || chunk.last_ns == 0;
  in.skip(there);
  try {
    chunk.compression = compression_named(name);
  } catch (const Damage& damage) {
    count_fault(at, damage.what);
    return;
  }
  chunks_.push_back(chunk);
}

// Messages that lie in no chunk are taken together in runs.
void McapBag::add_message(std::uint64_t at, std::uint64_t size, std::int64_t stamp_ns) {
  if (run_open_ && chunks_.back().offset + chunks_.back().packed_size == at &&
      chunks_.back().packed_size < kRunBytes) {
    BagChunk& run = chunks_.back();
    run.packed_size += size;
    run.first_ns = std::min(run.first_ns, stamp_ns);
    run.last_ns = std::max(run.last_ns, stamp_ns);
    return;
  }
  run_open_ = true;
  BagChunk run;
  run.offset = at;
  run.packed_size = size;
  run.first_ns = run.last_ns = stamp_ns;
  chunks_.push_back(run);
}

// The topics, from the end of the file. False if there is no summary, or none with channels.
bool McapBag::read_summary() {
  constexpr std::uint64_t footer_bytes = kHeadBytes + 20 + kMagicBytes;
  if (file_->size() < kMagicBytes + footer_bytes) return false;
  const std::uint64_t footer_at = file_->size() - footer_bytes;
  bool any = false;
  std::string statistics;  // to be read last: it needs the channels
  try {
    const auto footer = file_->stream(footer_at, footer_bytes);
    if (footer->number<std::uint8_t>() != kFooter || footer->number<std::uint64_t>() != 20) return false;
    const auto summary_at = footer->number<std::uint64_t>();
    if (summary_at < kMagicBytes || summary_at >= footer_at) return false;
    const auto in = file_->stream(summary_at, footer_at - summary_at);
    for (char head[kHeadBytes]; in->read(head, sizeof head) == sizeof head;) {
      const auto opcode = static_cast<std::uint8_t>(head[0]);
      const auto length = little_endian<std::uint64_t>(head + 1);
      if ((opcode != kSchema && opcode != kChannel && opcode != kStatistics) ||
          length > kLongestDescription) {
        in->skip(length);
        continue;
      }
      std::string bytes;
      in->append_to(bytes, length);
      if (opcode == kStatistics) {
        statistics = bytes;
        continue;
      }
      learn(opcode, bytes);
      any = any || opcode == kChannel;
    }
    if (!statistics.empty()) learn_counts(statistics);
  } catch (const Damage&) {
    return false;
  }
  return any;
}

}  // namespace

std::unique_ptr<BagReader> open_mcap_bag(std::unique_ptr<BagFile> file) {
  return std::make_unique<McapBag>(std::move(file));
}

}  // namespace parloc
