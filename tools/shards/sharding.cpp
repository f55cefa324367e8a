#include "tools/shards/sharding.h"

#include <fmt/format.h>

#include "common/error.h"
#include "tools/program/commands.h"

namespace parloc::tools::shards {

void add_shard_options(CLI::App& app, ShardOptions& o) {
  add_text_option(app, "--shard", o.shard, "I/N", "Only this part of the trials, into --out")->group("");
  add_text_option(app, "--merged", o.merged, "DIR", "Results of these shards")->group("");
}

void check_shard_options(const ShardOptions& o, const std::string& out, bool json) {
  if (o.shard.empty()) return;
  if (out.empty()) throw Error(ErrorKind::usage, "--shard: expected --out DIR as well, for its results");
  if (json || !o.merged.empty())
    throw Error(ErrorKind::usage, "--shard writes no report: expected neither --json nor --merged");
}

Parts::Parts(const ShardOptions& o, const std::string& typed, const Config& config, std::size_t items,
             const std::function<Inputs()>& inputs) {
  if (!o.shard.empty()) shard_ = shard_head(typed, config, inputs(), items, shard_from_text(o.shard));
  if (o.merged.empty()) return;
  merged_ = std::make_unique<Merged>(o.merged);
  merged_->check(shard_head(typed, config, inputs(), items, {1, merged_->head().shard.of}));
}

int compute_shard(
    const std::string& folder, const ShardHead& head, bool quiet,
    const std::function<void(const std::vector<std::size_t>& items, ShardFile& file)>& compute) {
  ShardFile file(folder, head);
  const std::size_t all = head.shard.items(head.items).size();
  const std::vector<std::size_t> items = file.missing();
  if (!items.empty()) compute(items, file);
  const std::size_t left = file.missing().size();
  if (!quiet)
    fmt::print("shard {} of {}: {} of its {} trials are in {}{}\n", head.shard.number, head.shard.of,
               all - left, all, folder,
               items.size() < all ? fmt::format(", {} of them from before", all - items.size()) : "");
  return left > 0 ? kExitInterrupted : 0;
}

}  // namespace parloc::tools::shards
