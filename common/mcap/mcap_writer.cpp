#include "common/mcap/mcap_writer.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>
#include <vector>

#include "common/bag/mcap_format.h"
#include "common/error.h"

namespace parloc {

namespace {

using namespace mcap;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr int kCompressionLevel = 1;  // ranges hardly get smaller by more, only later
constexpr const char* kCompression = "zstd";

template <class Number>
void put(std::string& to, Number value) {
  for (std::size_t k = 0; k < sizeof(Number); ++k)
    to += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * k) & 0xff);
}
void put_text(std::string& to, std::string_view text) {
  put(to, static_cast<std::uint32_t>(text.size()));
  to += text;
}
void put_record(std::string& to, Opcode opcode, std::string_view fields) {
  put(to, static_cast<std::uint8_t>(opcode));
  put(to, static_cast<std::uint64_t>(fields.size()));
  to += fields;
}
std::string record(Opcode opcode, std::string_view fields) {
  std::string bytes;
  put_record(bytes, opcode, fields);
  return bytes;
}

std::uint32_t checksum(std::string_view bytes) {
  uLong sum = crc32(0, nullptr, 0);
  // zlib takes 32 bits of a length.
  for (std::size_t at = 0; at < bytes.size(); at += std::size_t{1} << 30) {
    const std::string_view part = bytes.substr(at, std::size_t{1} << 30);
    sum = crc32(sum, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(part.size()));
  }
  return static_cast<std::uint32_t>(sum);
}

/// As rosbag2 writes it up to version 8 of its metadata: keep last, reliable; durability 1 is
/// transient-local, 2 volatile. Endless times are 2^63 - 1 ns.
std::string quality_of_service(bool latched) {
  const std::string endless = "\n    sec: 9223372036\n    nsec: 854775807";
  return fmt::format(
      "- history: 1\n  depth: {0}\n  reliability: 1\n  durability: {1}\n  deadline:{2}\n  lifespan:{2}\n"
      "  liveliness: 1\n  liveliness_lease_duration:{2}\n  avoid_ros_namespace_conventions: false",
      latched ? 1 : 10, latched ? 1 : 2, endless);
}

std::string pairs(const std::map<std::string, std::string>& values) {
  std::string items, bytes;
  for (const auto& [key, value] : values) {
    put_text(items, key);
    put_text(items, value);
  }
  put_text(bytes, items);
  return bytes;
}

}  // namespace

struct McapWriter::State {
  using Clock = std::chrono::steady_clock;
  struct Topic {
    std::uint64_t messages = 0;
    std::string index;  ///< Of the open chunk: times and offsets of its messages.
  };

  State(Sink sink_, double longest_chunk_s_)
      : sink(std::move(sink_)), longest_chunk_s(longest_chunk_s_), zstd(ZSTD_createCCtx(), ZSTD_freeCCtx) {
    chunk.reserve(kChunkBytes + kChunkBytes / 8);
  }

  void give(std::string_view bytes) {
    if (!std::exchange(begun, true)) begin();
    sink(bytes);
    given += bytes.size();
  }
  void begin();
  void add_message(std::uint16_t id, std::uint64_t stamp_ns, std::string_view message);
  void end_chunk();
  std::string statistics() const;

  Sink sink;
  double longest_chunk_s;
  std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> zstd;
  bool begun = false;
  std::uint64_t given = 0;  ///< Bytes.
  std::map<std::string, std::uint16_t> schema_of_type;
  std::string schemas, channels;  ///< Their records, for the summary.
  std::vector<Topic> topics;      ///< By number - 1.
  std::string chunk, packed;      ///< The open chunk's records, and room for it packed.
  std::uint64_t chunk_messages = 0, first_ns = 0, last_ns = 0;  ///< Of the open chunk.
  Clock::time_point chunk_begun;
  std::string chunk_index;  ///< Records for the summary.
  std::uint32_t chunks = 0;
  std::uint64_t messages = 0, earliest_ns = 0, latest_ns = 0;  ///< Of all.
  std::string metadata_index;
};

// rosbag2 takes the quality of service for that of its old form only where a record of its own says nothing
// else: files of its release Humble look so.
void McapWriter::State::begin() {
  std::string fields;
  put_text(fields, "ros2");
  put_text(fields, "parloc");
  give(kMagic);
  give(record(kHeader, fields));
  fields.clear();
  put_text(fields, "rosbag2");
  const std::string metadata = record(kMetadata, fields + pairs({{"ROS_DISTRO", "humble"}}));
  std::string index;
  put(index, given);
  put(index, static_cast<std::uint64_t>(metadata.size()));
  metadata_index = record(kMetadataIndex, index + fields);
  give(metadata);
}

void McapWriter::State::add_message(std::uint16_t id, std::uint64_t stamp_ns, std::string_view message) {
  Topic& topic = topics[id - 1u];
  if (chunk_messages == 0) {
    chunk_begun = Clock::now();
    first_ns = last_ns = stamp_ns;
  }
  first_ns = std::min(first_ns, stamp_ns);
  last_ns = std::max(last_ns, stamp_ns);
  earliest_ns = messages == 0 ? stamp_ns : std::min(earliest_ns, stamp_ns);
  latest_ns = messages == 0 ? stamp_ns : std::max(latest_ns, stamp_ns);
  put(topic.index, stamp_ns);
  put(topic.index, static_cast<std::uint64_t>(chunk.size()));
  std::string fields;
  put(fields, id);
  put(fields, static_cast<std::uint32_t>(topic.messages));
  put(fields, stamp_ns);
  put(fields, stamp_ns);
  put(chunk, static_cast<std::uint8_t>(kMessage));
  put(chunk, static_cast<std::uint64_t>(fields.size() + message.size()));
  chunk += fields;
  chunk += message;
  ++topic.messages, ++chunk_messages, ++messages;
  const std::chrono::duration<double> age = Clock::now() - chunk_begun;
  if (chunk.size() >= kChunkBytes || age.count() >= longest_chunk_s) end_chunk();
}

void McapWriter::State::end_chunk() {
  if (chunk_messages == 0) return;
  give({});  // what stands before
  packed.resize(ZSTD_compressBound(chunk.size()));
  const std::size_t packed_bytes = ZSTD_compressCCtx(zstd.get(), packed.data(), packed.size(), chunk.data(),
                                                     chunk.size(), kCompressionLevel);
  if (ZSTD_isError(packed_bytes) != 0)
    throw Error(ErrorKind::internal, fmt::format("zstd: {}", ZSTD_getErrorName(packed_bytes)));
  std::string head;
  put(head, first_ns);
  put(head, last_ns);
  put(head, static_cast<std::uint64_t>(chunk.size()));
  put(head, checksum(chunk));
  put_text(head, kCompression);
  put(head, static_cast<std::uint64_t>(packed_bytes));
  std::string bytes;
  put(bytes, static_cast<std::uint8_t>(kChunk));
  put(bytes, static_cast<std::uint64_t>(head.size() + packed_bytes));
  bytes += head;
  bytes.append(packed.data(), packed_bytes);
  const std::uint64_t chunk_at = given, chunk_bytes = bytes.size();
  std::string offsets;
  for (std::size_t k = 0; k < topics.size(); ++k) {
    if (topics[k].index.empty()) continue;
    put(offsets, static_cast<std::uint16_t>(k + 1));
    put(offsets, chunk_at + bytes.size());
    std::string index;
    put(index, static_cast<std::uint16_t>(k + 1));
    put_text(index, std::exchange(topics[k].index, {}));
    put_record(bytes, kMessageIndex, index);
  }
  std::string index;
  put(index, first_ns);
  put(index, last_ns);
  put(index, chunk_at);
  put(index, chunk_bytes);
  put_text(index, offsets);
  put(index, static_cast<std::uint64_t>(bytes.size()) - chunk_bytes);
  put_text(index, kCompression);
  put(index, static_cast<std::uint64_t>(packed_bytes));
  put(index, static_cast<std::uint64_t>(chunk.size()));
  put_record(chunk_index, kChunkIndex, index);
  give(bytes);
  chunk.clear();
  chunk_messages = 0;
  ++chunks;
}

std::string McapWriter::State::statistics() const {
  std::string fields, counts;
  put(fields, messages);
  put(fields, static_cast<std::uint16_t>(schema_of_type.size()));
  put(fields, static_cast<std::uint32_t>(topics.size()));
  put(fields, std::uint32_t{0});  // attachments
  put(fields, std::uint32_t{1});  // metadata
  put(fields, chunks);
  put(fields, earliest_ns);
  put(fields, latest_ns);
  for (std::size_t k = 0; k < topics.size(); ++k) {
    put(counts, static_cast<std::uint16_t>(k + 1));
    put(counts, topics[k].messages);
  }
  put_text(fields, counts);
  return record(kStatistics, fields);
}

McapWriter::McapWriter(Sink sink, double longest_chunk_s)
    : state_(std::make_unique<State>(std::move(sink), longest_chunk_s)) {}

McapWriter::~McapWriter() = default;

std::uint16_t McapWriter::add_topic(const McapTopic& topic) {
  State& s = *state_;
  if (s.topics.size() == UINT16_MAX) throw Error(ErrorKind::output, "an MCAP file has at most 65535 topics");
  const auto next = static_cast<std::uint16_t>(s.schema_of_type.size() + 1);
  const auto [schema, is_new] = s.schema_of_type.emplace(topic.type, next);
  if (is_new) {
    std::string fields;
    put(fields, schema->second);
    put_text(fields, topic.type);
    put_text(fields, "ros2msg");
    put_text(fields, topic.definition);
    put_record(s.schemas, kSchema, fields);
    put_record(s.chunk, kSchema, fields);
  }
  s.topics.emplace_back();
  const auto id = static_cast<std::uint16_t>(s.topics.size());
  std::string fields;
  put(fields, id);
  put(fields, schema->second);
  put_text(fields, topic.name);
  put_text(fields, "cdr");
  fields += pairs({{"offered_qos_profiles", quality_of_service(topic.latched)}});
  put_record(s.channels, kChannel, fields);
  put_record(s.chunk, kChannel, fields);
  return id;
}

void McapWriter::write(std::uint16_t topic, std::int64_t stamp_ns, std::string_view message) {
  state_->add_message(topic, static_cast<std::uint64_t>(std::max<std::int64_t>(stamp_ns, 0)), message);
}

void McapWriter::finish() {
  State& s = *state_;
  s.end_chunk();
  s.give(record(kDataEnd, std::string(4, '\0')));  // whose checksum nobody needs: chunks have their own
  const std::uint64_t summary_at = s.given;
  std::string summary, offsets;
  const auto add_group = [&](Opcode opcode, const std::string& records) {
    if (records.empty()) return;
    std::string fields;
    put(fields, static_cast<std::uint8_t>(opcode));
    put(fields, summary_at + summary.size());
    put(fields, static_cast<std::uint64_t>(records.size()));
    put_record(offsets, kSummaryOffset, fields);
    summary += records;
  };
  add_group(kSchema, s.schemas);
  add_group(kChannel, s.channels);
  add_group(kStatistics, s.statistics());
  add_group(kChunkIndex, s.chunk_index);
  add_group(kMetadataIndex, s.metadata_index);
  const std::uint64_t offsets_at = summary_at + summary.size();
  summary += offsets;
  // The footer, which the checksum covers up to itself.
  put(summary, static_cast<std::uint8_t>(kFooter));
  put(summary, std::uint64_t{20});
  put(summary, summary_at);
  put(summary, offsets_at);
  put(summary, checksum(summary));
  s.give(summary);
  s.give(kMagic);
}

}  // namespace parloc
