// The paths that particles came: a tree, since resampled particles share what is behind them. Chains that no
// particle descends from are forgotten.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/math/pose.h"

namespace parloc {

class ByteReader;
class ByteWriter;

class PathTree {
 public:
  struct Node {
    std::uint32_t parent, children, step;
    Pose pose;
  };
  static constexpr std::uint32_t kNone = 0xffffffffu;

  explicit PathTree(std::size_t particles) : tip_(particles, kNone) {}

  /// Poses of a step by slot, and the slot of the step before that each came from.
  void add(const std::vector<Pose>& poses, const std::vector<std::uint32_t>& ancestor);
  /// Poses of a particle, by step.
  std::vector<Pose> path(std::size_t particle) const;
  /// By step: how many different poses the particles of now have behind them there.
  std::vector<std::size_t> distinct() const;
  std::size_t steps() const { return steps_; }
  std::size_t nodes() const { return node_.size() - free_.size(); }
  void save(ByteWriter& w) const;
  /// What save() wrote, of as many particles; a pose for which on_map is false cannot be. Throws
  /// Error{input}.
  void load(ByteReader& r, const std::function<bool(const Pose&)>& on_map);

 private:
  std::uint32_t make(const Node& node);
  void drop(std::uint32_t at);

  std::vector<Node> node_;
  std::vector<std::uint32_t> free_, tip_;
  std::uint32_t steps_ = 0;
};

}  // namespace parloc
