// The results of a shard, in a file that grows trial by trial.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "tools/shards/shard_head.h"

namespace parloc::tools::shards {

/// The file in the folder of a shard; a file as it is.
std::string shard_path(const std::string& folder);

/// Throws Error{input} for a file that is none.
ShardHead read_shard_head(const std::string& path);

/// Where a trial's bytes are.
struct StoredTrial {
  std::size_t item = 0;
  double took_s = 0.0;  ///< To compute.
  std::uint64_t offset = 0;
  std::uint32_t size = 0;
};

/// What a file holds. What was being written when the shard was killed is no trial.
struct ShardContents {
  ShardHead head;
  std::vector<StoredTrial> trials;
  std::uint64_t whole_bytes = 0;  ///< Up to the last whole trial.
  bool damaged = false;           ///< Something that is no trial stands before more bytes.
};
/// Reads all of it, each trial against its checksum. Throws Error{input} for a file that is none.
ShardContents read_shard(const std::string& path);

/// Takes results in. Whatever happens to this program, those that were added stay.
class ShardFile {
 public:
  /// Goes on with what is in the folder, which is made if need be. Throws Error{input} if that is of another
  /// run or shard, Error{output} if it cannot be written, or if another program is writing there.
  ShardFile(const std::string& folder, const ShardHead& head);
  ~ShardFile();
  ShardFile(const ShardFile&) = delete;
  ShardFile& operator=(const ShardFile&) = delete;

  /// Of the shard's trials those that are not there yet, in order.
  std::vector<std::size_t> missing() const;
  /// From any thread. Throws Error{output}; what was there before stays whole.
  void add(std::size_t item, double took_s, std::string_view bytes);

 private:
  void write(std::string_view bytes);

  std::string path_;
  ShardHead head_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::vector<bool> there_;  ///< By item.
  std::mutex mutex_;
};

}  // namespace parloc::tools::shards
