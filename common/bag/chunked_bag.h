// What bags that consist of chunks have in common: messages in the order of their recording from chunks in
// any order, with bounded memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/bag/bag.h"
#include "common/bag/bytes/byte_stream.h"
#include "common/bag/bytes/decompress.h"

namespace parloc {

/// Where messages lie together.
struct BagChunk {
  std::uint64_t offset = 0;       ///< Of the records in the file.
  std::uint64_t packed_size = 0;  ///< Of the records in the file [bytes].
  Compression compression = Compression::none;
  std::int64_t first_ns = 0, last_ns = 0;  ///< Of the messages; first_ns decides when it is unpacked.
  bool has_checksum = false;
  std::uint32_t checksum = 0;  ///< CRC-32 of the unpacked records.
};

/// Messages of one chunk, the selected ones, in the order of their stamps.
struct ChunkMessages {
  struct Entry {
    std::int64_t stamp_ns;
    std::size_t topic, offset, size;
  };
  std::vector<Entry> entries;
  std::string bytes;
};

/// The records of a chunk, one by one. Throws Damage.
class ChunkRecords {
 public:
  virtual ~ChunkRecords() = default;
  /// Appends the next message if it is selected; passes over whatever else there is. False at the end.
  virtual bool next(ChunkMessages& messages) = 0;
};

class ChunkedBag : public BagReader {
 public:
  const std::vector<BagTopic>& topics() const final { return topics_; }
  bool is_empty(std::size_t topic) const final { return counted_ && counts_[topic] == 0; }
  std::int64_t first_stamp_ns() const final;
  void select(const std::vector<bool>& topics) final;
  bool next(BagMessage& message) final;
  const BagFaults& faults() const final { return faults_; }
  double progress() const final;

 protected:
  /// Chunks that are not compressed are cut to about this size [bytes].
  static constexpr std::uint64_t kRunBytes = std::uint64_t{1} << 20;

  /// Of a message whose topic nobody described.
  static constexpr std::size_t kNoTopic = static_cast<std::size_t>(-1);

  explicit ChunkedBag(std::unique_ptr<BagFile> file);
  ~ChunkedBag() override;

  virtual std::unique_ptr<ChunkRecords> open_chunk(const BagChunk& chunk) = 0;

  /// The index of the topic, which is new or known already.
  std::size_t add_topic(BagTopic topic);
  /// The next `size` bytes of the stream are a message of that topic: appends it if it is selected, else
  /// passes over it and gives false. Throws Damage if they are too many or too few; what was there before
  /// stays.
  bool take_message(ByteStream& in, std::size_t topic, std::int64_t stamp_ns, std::uint64_t size,
                    ChunkMessages& messages);
  bool wanted(std::size_t topic) const { return topic < wanted_.size() && wanted_[topic]; }
  /// Unpacks all chunks once with nothing selected, so that open_chunk()'s records can tell what is in them:
  /// topics, and times through take_message(). For files without an index.
  void look_through();
  /// The index of the file says how many messages of topics there are.
  void add_count(std::size_t topic, std::uint64_t messages);
  /// One fault, told once for each place in the file.
  void count_fault(std::uint64_t offset, const std::string& what);

  std::unique_ptr<BagFile> file_;
  std::vector<BagChunk> chunks_;

 private:
  struct Cursor;
  void open_next_chunk();
  bool refill(Cursor& cursor);
  void make_room(std::size_t bytes);
  bool unpack_again(Cursor& cursor);
  void advance();
  /// The one with the earliest message; none: the number of cursors.
  std::size_t earliest() const;

  std::vector<BagTopic> topics_;
  std::vector<bool> wanted_;
  bool counted_ = false;               ///< counts_ holds for the file.
  std::vector<std::uint64_t> counts_;  ///< Messages of each topic.
  BagFaults faults_;
  std::set<std::uint64_t> faulty_places_;
  std::vector<std::size_t> order_;  ///< Of chunks_, by time.
  std::size_t next_chunk_ = 0;      ///< Index into order_.
  std::vector<std::unique_ptr<Cursor>> cursors_;
  ChunkMessages spare_;      ///< Of the cursor that ended last: its memory is used again.
  Cursor* given_ = nullptr;  ///< Whose message was given out last.
  BagChunk* looked_at_ = nullptr;
};

}  // namespace parloc
