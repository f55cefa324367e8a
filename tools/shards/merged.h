// The results of all shards of a run, as if one program had computed them.
#pragma once

#include <cstddef>
#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "common/eval/result_stream.h"
#include "common/file/bytes.h"
#include "tools/shards/shard_file.h"

namespace parloc::tools::shards {

class Merged {
 public:
  /// Looks through all files. Throws Error{input} that names what is missing, doubled, of another run,
  /// unfinished or damaged.
  explicit Merged(const std::vector<std::string>& folders);

  const ShardHead& head() const { return head_; }
  std::size_t shards() const { return places_.size(); }
  double took_s() const { return took_s_; }  ///< Of all trials, summed.

  /// Throws Error{input} unless this program, told to do the same here, would read the same and be the same.
  void check(const ShardHead& here) const;

  /// The trials in their order: `get` takes one from its bytes. Holds one at a time in memory. The object
  /// must outlive what is returned.
  template <class Result>
  ResultStream<Result> results(const std::function<Result(ByteReader&)>& get) const {
    return {head().items, [this, get](const typename ResultStream<Result>::Visit& visit) {
              each([&](ByteReader& reader) { visit(get(reader)); });
            }};
  }

 private:
  struct Place {
    std::uint64_t offset;
    std::uint32_t size;
  };
  void check_shards() const;
  void find_trials(ShardContents contents, const std::string& path);
  void each(const std::function<void(ByteReader&)>& take) const;

  std::vector<std::string> paths_;
  ShardHead head_;                          ///< Of the first file.
  std::vector<std::vector<Place>> places_;  ///< Of each file, in the order of its items.
  std::vector<std::size_t> file_of_;        ///< By the shard's number, from 0 on; kNone without.
  double took_s_ = 0.0;
};

}  // namespace parloc::tools::shards
