#include "common/bag/ros1_bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/bag/chunked_bag.h"
#include "common/bag/type_name.h"
#include "common/error.h"

namespace parloc {

namespace {

constexpr std::string_view kVersionLine = "#ROSBAG V2.0\n";
constexpr std::uint32_t kLongestHeader = std::uint32_t{4} << 20;

enum RecordOpcode : std::uint8_t {
  kMessageRecord = 2,
  kBagHeaderRecord = 3,
  kIndexRecord = 4,
  kChunkRecord = 5,
  kChunkInfoRecord = 6,
  kConnectionRecord = 7
};

/// The header of a record: "name=value" fields, each with its length before it.
class Header {
 public:
  /// Empty at the end of the stream. Throws Damage.
  static std::optional<Header> read(ByteStream& in) {
    char length[4];
    const std::size_t got = in.read(length, sizeof length);
    if (got == 0) return std::nullopt;
    if (got < sizeof length) throw Damage{"cut off"};
    return Header(in, little_endian<std::uint32_t>(length));
  }
  Header(ByteStream& in, std::uint32_t size) {
    if (size > kLongestHeader)
      throw Damage{fmt::format("expected the header of a record, found a length of {}", size)};
    in.append_to(bytes_, size);
  }

  /// The value; empty if there is no such field.
  std::string_view field(std::string_view name) const {
    std::string_view left = bytes_;
    while (left.size() >= 4) {
      const auto size = little_endian<std::uint32_t>(left.data());
      left.remove_prefix(4);
      if (size > left.size()) break;
      const std::string_view field = left.substr(0, size);
      left.remove_prefix(size);
      if (field.size() > name.size() && field[name.size()] == '=' && field.substr(0, name.size()) == name)
        return field.substr(name.size() + 1);
    }
    return {};
  }
  /// Throws Damage if there is none.
  template <class Number>
  Number number(std::string_view name) const {
    const std::string_view value = field(name);
    if (value.size() != sizeof(Number))
      throw Damage{fmt::format("expected a field '{}' in the header of a record", name)};
    return little_endian<Number>(value.data());
  }
  std::uint8_t opcode() const { return number<std::uint8_t>("op"); }
  std::int64_t stamp_ns(std::string_view name) const {
    const auto value = number<std::uint64_t>(name);  // seconds, then nanoseconds
    return static_cast<std::int64_t>(value & 0xFFFFFFFFu) * 1000000000 +
           static_cast<std::int64_t>(value >> 32);
  }

 private:
  std::string bytes_;
};

/// The bytes of a header that lies in memory.
class TextStream final : public ByteStream {
 public:
  explicit TextStream(std::string_view text) : text_(text) {}
  std::size_t read(char* to, std::size_t size) override {
    const std::size_t part = std::min(size, text_.size());
    std::copy_n(text_.data(), part, to);
    text_.remove_prefix(part);
    return part;
  }

 private:
  std::string_view text_;
};

class Ros1Bag final : public ChunkedBag {
 public:
  explicit Ros1Bag(std::unique_ptr<BagFile> file) : ChunkedBag(std::move(file)) {
    if (!read_index()) {
      chunks_.clear();
      walk();
      look_through();
    }
    select(std::vector<bool>(topics().size(), true));
  }
  std::string container() const override { return "ros1"; }

 protected:
  std::unique_ptr<ChunkRecords> open_chunk(const BagChunk& chunk) override;

 private:
  struct Records;
  bool read_index();
  void walk();
  /// Of the chunk record whose header was read; the stream stands before the length of its data.
  BagChunk chunk_at(std::uint64_t data_at, const Header& header, ByteStream& in) const;
  void learn(const Header& header, ByteStream& in, std::uint32_t size);
  void learn_counts(ByteStream& in, std::uint32_t size);

  std::map<std::uint32_t, std::size_t> connection_topic_;  ///< Index into topics().
};

struct Ros1Bag::Records final : ChunkRecords {
  Records(Ros1Bag& bag_, std::unique_ptr<ByteStream> stream_) : bag(bag_), stream(std::move(stream_)) {}

  bool next(ChunkMessages& messages) override {
    for (;;) {
      const std::optional<Header> header = Header::read(*stream);
      if (!header) return false;
      const auto size = stream->number<std::uint32_t>();
      const std::uint8_t opcode = header->opcode();
      if (opcode == kConnectionRecord) {
        bag.learn(*header, *stream, size);
      } else if (opcode == kMessageRecord) {
        if (take_message(*header, size, messages)) return true;
      } else {
        stream->skip(size);
      }
    }
  }

  bool take_message(const Header& header, std::uint32_t size, ChunkMessages& messages) {
    const std::int64_t stamp_ns = header.stamp_ns("time");
    const auto topic = bag.connection_topic_.find(header.number<std::uint32_t>("conn"));
    return bag.take_message(*stream, topic == bag.connection_topic_.end() ? kNoTopic : topic->second,
                            stamp_ns, size, messages);
  }

  Ros1Bag& bag;
  std::unique_ptr<ByteStream> stream;
};

std::unique_ptr<ChunkRecords> Ros1Bag::open_chunk(const BagChunk& chunk) {
  return std::make_unique<Records>(
      *this, decompressed(chunk.compression, file_->stream(chunk.offset, chunk.packed_size)));
}

// The data of a connection are a header of their own, which names the type.
void Ros1Bag::learn(const Header& header, ByteStream& in, std::uint32_t size) {
  if (size > kLongestHeader) throw Damage{"expected a shorter description of a topic"};
  std::string bytes;
  in.append_to(bytes, size);
  TextStream text(bytes);
  const Header description(text, size);
  const auto id = header.number<std::uint32_t>("conn");
  connection_topic_.emplace(
      id, add_topic({std::string(header.field("topic")), type_name(description.field("type")), "ros1"}));
}

// A connection and its messages in a chunk, for each connection.
void Ros1Bag::learn_counts(ByteStream& in, std::uint32_t size) {
  for (; size >= 8; size -= 8) {
    const auto topic = connection_topic_.find(in.number<std::uint32_t>());
    const auto messages = in.number<std::uint32_t>();
    if (topic != connection_topic_.end()) add_count(topic->second, messages);
  }
  in.skip(size);
}

BagChunk Ros1Bag::chunk_at(std::uint64_t data_at, const Header& header, ByteStream& in) const {
  BagChunk chunk;
  const auto size = in.number<std::uint32_t>();
  chunk.offset = data_at + 4;
  chunk.packed_size = std::min<std::uint64_t>(size, file_->size() - chunk.offset);
  chunk.compression = compression_named(header.field("compression"));
  return chunk;
}

// Topics and chunks from the end of the file, each chunk looked for where it should be. False if anything is
// missing or wrong.
bool Ros1Bag::read_index() {
  try {
    const auto begin = file_->stream(kVersionLine.size(), file_->size());
    const std::optional<Header> bag = Header::read(*begin);
    if (!bag || bag->opcode() != kBagHeaderRecord) return false;
    const auto index_at = bag->number<std::uint64_t>("index_pos");
    if (index_at <= kVersionLine.size() || index_at > file_->size()) return false;
    const auto chunk_count = bag->number<std::uint32_t>("chunk_count");
    const auto in = file_->stream(index_at, file_->size());
    while (const std::optional<Header> header = Header::read(*in)) {
      const auto size = in->number<std::uint32_t>();
      if (header->opcode() == kConnectionRecord) {
        learn(*header, *in, size);
        continue;
      }
      if (header->opcode() != kChunkInfoRecord) return false;
      const auto at = header->number<std::uint64_t>("chunk_pos");
      const auto record = file_->stream(at, file_->size());
      const std::uint32_t header_size = record->number<std::uint32_t>();
      const Header chunk_header(*record, header_size);
      if (chunk_header.opcode() != kChunkRecord) return false;
      BagChunk chunk = chunk_at(at + 4 + header_size, chunk_header, *record);
      chunk.first_ns = header->stamp_ns("start_time");
      chunk.last_ns = header->stamp_ns("end_time");
      chunks_.push_back(chunk);
      learn_counts(*in, size);
    }
    return chunks_.size() == chunk_count;
  } catch (const Damage&) {
    return false;
  }
}

// Without an index: record after record.
void Ros1Bag::walk() {
  count_fault(kVersionLine.size(), "no index, or a damaged one: read from front to back");
  std::uint64_t at = kVersionLine.size();
  try {
    for (;;) {
      const auto in = file_->stream(at, file_->size());
      char length[4];
      const std::size_t got = in->read(length, sizeof length);
      if (got == 0) return;
      if (got < sizeof length) throw Damage{"cut off"};
      const auto header_size = little_endian<std::uint32_t>(length);
      const Header header(*in, header_size);
      const std::uint64_t data_at = at + 4 + header_size;
      const std::uint8_t opcode = header.opcode();
      if (opcode == kChunkRecord) {
        chunks_.push_back(chunk_at(data_at, header, *in));
        at = chunks_.back().offset + chunks_.back().packed_size;
        continue;
      }
      std::uint64_t size = in->number<std::uint32_t>();
      // Some writers of 2010 state the length of another entry; what follows are 12 bytes for each.
      if (opcode == kIndexRecord) size = std::uint64_t{12} * header.number<std::uint32_t>("count");
      if (opcode == kConnectionRecord) learn(header, *in, static_cast<std::uint32_t>(size));
      at = data_at + 4 + size;
      if (at > file_->size()) throw Damage{"cut off"};
    }
  } catch (const Damage& damage) {
    count_fault(at, damage.what + ": what is whole before is read");
  }
}

}  // namespace

std::unique_ptr<BagReader> open_ros1_bag(std::unique_ptr<BagFile> file) {
  char line[13];
  std::size_t got = 0;
  try {
    got = file->read_at(0, line, sizeof line);
  } catch (const Damage& damage) {
    throw input_error(file->path(), 0, damage.what);
  }
  const std::string_view version(line, got);
  if (version != kVersionLine)
    throw input_error(
        file->path(), 0,
        fmt::format(
            "expected a ROS 1 bag of format 2.0, found '{}': `rosbag filter OLD NEW True` writes it anew",
            printable(version.substr(0, version.find('\n')))));
  return std::make_unique<Ros1Bag>(std::move(file));
}

}  // namespace parloc
