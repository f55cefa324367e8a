// What commands with many trials do to be computed in parts.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "tools/shards/merged.h"
#include "tools/shards/shard_file.h"

namespace parloc::tools::shards {

/// The command line; what was not given is empty.
struct ShardOptions {
  std::string shard;                ///< "3/64".
  std::vector<std::string> merged;  ///< Folders of shards, whose results are taken; `parloc merge` says so.
};
/// Not in the list of the help, which has no room.
void add_shard_options(CLI::App& app, ShardOptions& options);
/// Throws Error{usage} for a shard without a folder, or together with what a shard does not write.
void check_shard_options(const ShardOptions& options, const std::string& out, bool json);

/// What a run is, by its options: a shard of it, the results of all shards, or neither.
class Parts {
 public:
  /// `inputs` is asked for only if it matters. Throws as shard_from_text(), file_digest() and Merged.
  Parts(const ShardOptions& options, const std::string& typed, const Config& config, std::size_t items,
        const std::function<Inputs()>& inputs);
  const ShardHead* shard() const { return shard_ ? &*shard_ : nullptr; }
  const Merged* merged() const { return merged_.get(); }

 private:
  std::optional<ShardHead> shard_;
  std::unique_ptr<Merged> merged_;
};

/// Computes those of a shard's trials that are not in its folder yet. `compute` puts each result into the
/// file; it may end early. Gives the exit code.
int compute_shard(const std::string& folder, const ShardHead& head, bool quiet,
                  const std::function<void(const std::vector<std::size_t>& items, ShardFile& file)>& compute);

}  // namespace parloc::tools::shards
