#include "tools/shards/shard_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/error.h"
#include "common/map/map_reader.h"
#include "common/math/sha256.h"
#include "tools/program/typed_command.h"
#include "tools/report/machine/machine.h"
#include "tools/report/result_parts.h"

namespace parloc::tools::shards {
namespace {

namespace fs = std::filesystem;

void add_file(Sha256& sha, const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<char> part(std::size_t{1} << 16);
  while (in.read(part.data(), static_cast<std::streamsize>(part.size())), in.gcount() > 0)
    sha.add(part.data(), static_cast<std::size_t>(in.gcount()));
  if (in.bad() || !in.eof()) throw input_error(path, 0, "cannot be read");
}

/// Throws Json::exception.
std::size_t count_in(const Json& json, const char* name) {
  const Json& value = json.at(name);
  if (!value.is_number_unsigned()) throw Json::type_error::create(302, "expected a count", &value);
  return value;
}

}  // namespace

std::string file_digest(const std::string& path) {
  Sha256 sha;
  if (!fs::is_directory(path)) {
    add_file(sha, path);
    return sha.hex();
  }
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (entry.is_regular_file()) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    sha.add(name.c_str(), name.size() + 1);
    add_file(sha, (fs::path(path) / name).string());
  }
  return sha.hex();
}

std::string map_digest(const GridMap& map) {
  Sha256 sha;
  const Pose& at = map.T_map_grid;
  for (const double value : {map.resolution_m, at.x_m, at.y_m, at.theta_rad, static_cast<double>(map.width),
                             static_cast<double>(map.height)})
    sha.add(value);
  sha.add(map.cells.data(), map.cells.size() * sizeof map.cells[0]);
  for (const GridWall& wall : map.walls)
    for (const float v : {wall.ax, wall.ay, wall.bx, wall.by}) sha.add(v);
  return sha.hex();
}

Inputs inputs_of(const GridMap& map, const std::vector<std::string>& files) {
  Inputs inputs{{"map", map_digest(map)}};
  for (const std::string& file : files)
    if (!file.empty()) inputs.emplace_back(file, file_digest(file));
  return inputs;
}

void add_scenario(Inputs& inputs, const Scenario& scenario) {
  inputs.emplace_back(scenario.map_path, map_digest(read_map(scenario.map_path)));
  if (!scenario.path_file.empty()) inputs.emplace_back(scenario.path_file, file_digest(scenario.path_file));
}

ShardHead shard_head(const std::string& typed, const Config& config, Inputs inputs, std::size_t items,
                     const Shard& shard) {
  Config deciding = config;  // what computes decides nothing
  deciding.backend = BackendChoice::automatic;
  deciding.device = deciding.threads = 0;
  return {deciding_command(typed), kVersion, kCommit, config_to_yaml(deciding),
          std::move(inputs),       items,    shard};
}

std::string text_of(const ShardHead& head) {
  Json json{{"command", head.command},    {"version", head.version},  {"commit", head.commit},
            {"settings", head.settings},  {"inputs", Json::object()}, {"items", head.items},
            {"shard", head.shard.number}, {"of", head.shard.of}};
  for (const auto& [input, digest] : head.inputs) json["inputs"][input] = digest;
  return file_text(json);
}

ShardHead head_from_text(const std::string& text, const std::string& file) {
  ShardHead head;
  try {
    const Json json = Json::parse(text);
    head = {json.at("command"),
            json.at("version"),
            json.at("commit"),
            json.at("settings"),
            {},
            count_in(json, "items"),
            {count_in(json, "shard"), count_in(json, "of")}};
    for (const auto& [path, digest] : json.at("inputs").items()) head.inputs.emplace_back(path, digest);
  } catch (const Json::exception&) {
    throw input_error(file, 0, "expected the results of a shard, found a damaged head");
  }
  const bool possible =
      head.shard.number >= 1 && head.shard.number <= head.shard.of && head.shard.of <= Shard::kMost;
  if (!possible) throw input_error(file, 0, "expected the results of a shard, found an impossible number");
  return head;
}

std::string difference(const ShardHead& a, const std::string& name_a, const ShardHead& b,
                       const std::string& name_b) {
  const auto told = [&](const char* what, const std::string& of_a, const std::string& of_b) {
    return fmt::format("{} is of {} '{}', {} of '{}'", name_b, what, printable(of_b), name_a,
                       printable(of_a));
  };
  if (a.command != b.command) return told("the command", a.command, b.command);
  if (a.version != b.version || a.commit != b.commit)
    return told("parloc", a.version + " " + a.commit, b.version + " " + b.commit);
  if (a.settings != b.settings) return fmt::format("{} is of other settings than {}", name_b, name_a);
  for (const auto& [input, digest] : a.inputs)
    if (std::find(b.inputs.begin(), b.inputs.end(), std::pair(input, digest)) == b.inputs.end())
      return fmt::format("{} has read another {} than {}", name_b, printable(input), name_a);
  if (a.inputs.size() != b.inputs.size())
    return fmt::format("{} has read other files than {}", name_b, name_a);
  if (a.items != b.items) return told("trials", std::to_string(a.items), std::to_string(b.items));
  if (a.shard.of != b.shard.of)
    return told("a number of shards", std::to_string(a.shard.of), std::to_string(b.shard.of));
  return {};
}

}  // namespace parloc::tools::shards
