// What the shards of one run have in common, and which of them one is.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/map/grid_map.h"
#include "common/simulator/scenario.h"
#include "tools/shards/shard.h"

namespace parloc::tools::shards {

/// What was read: name, and SHA-256 of what it holds.
using Inputs = std::vector<std::pair<std::string, std::string>>;

/// Of a file, or of all files in a folder. Throws Error{input}.
std::string file_digest(const std::string& path);
std::string map_digest(const GridMap& map);
/// The map that is localized on, and files; an empty name is none. Throws Error{input}.
Inputs inputs_of(const GridMap& map, const std::vector<std::string>& files);
/// What a scenario names besides. Throws Error{input}.
void add_scenario(Inputs& inputs, const Scenario& scenario);

/// Two shards belong to one run if all but `shard.number` is equal: then so is every result.
struct ShardHead {
  std::string command;          ///< deciding_command().
  std::string version, commit;  ///< Of the program.
  std::string settings;         ///< Of the filters, as YAML.
  Inputs inputs;
  std::size_t items = 0;  ///< Of all shards together.
  Shard shard;
};

ShardHead shard_head(const std::string& typed, const Config& config, Inputs inputs, std::size_t items,
                     const Shard& shard);

std::string text_of(const ShardHead& head);  ///< JSON.
/// Throws Error{input} naming `file` for a text that is none.
ShardHead head_from_text(const std::string& text, const std::string& file);

/// Why they are no shards of one run: "`b` ..., `a` ...", the first thing that differs; empty if they are.
std::string difference(const ShardHead& a, const std::string& name_a, const ShardHead& b,
                       const std::string& name_b);

}  // namespace parloc::tools::shards
