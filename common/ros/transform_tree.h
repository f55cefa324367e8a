// Where frames are, as /tf and /tf_static say.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/ros/messages.h"
#include "common/ros/rigid_transform.h"

namespace parloc {

/// Frames of a robot. A frame that moves (/tf) remembers the last 10 s, at most 4096 transforms; one that
/// does not (/tf_static) its last value. Where both are said of one frame, what moves counts.
class TransformTree {
 public:
  /// Parents that are empty, frames that are their own parent, and transforms that are not rigid are left out
  /// and counted.
  void add(const TransformMessage& transform, bool is_static);
  /// Forgets where frames were that move: the clock was set.
  void forget_moving();

  /// T_target_source at that time: between two transforms of a frame that moves, else the nearest. Nothing if
  /// the frames are not connected.
  std::optional<RigidTransform> find(const std::string& target, const std::string& source,
                                     double stamp_s) const;
  bool knows(const std::string& frame) const;
  /// Whether /tf says where it is in its parent.
  bool moves(const std::string& frame) const;
  /// Empty if it has none.
  std::string parent_of(const std::string& frame) const;
  /// The frame on the chain from `frame` upwards whose parent is `ancestor`; empty if there is none.
  std::string child_on_the_way(const std::string& ancestor, const std::string& frame) const;
  std::vector<std::string> frames() const;

  std::size_t refused() const { return refused_; }
  /// One for each frame of which two places were said as if it did not move.
  struct Contradiction {
    std::string frame, text;  ///< One line for people.
  };
  const std::vector<Contradiction>& contradictions() const { return contradictions_; }
  /// The frame, its parent, and so on.
  std::vector<std::string> way_up(const std::string& frame) const;

 private:
  struct Stamped {
    double stamp_s;
    RigidTransform T_parent_child;
  };
  struct Frame {
    std::string parent;
    std::optional<RigidTransform> fixed;
    std::deque<Stamped> moving;  ///< In the order of their stamps.
    bool contradicted = false;
  };
  void contradict(const std::string& name, Frame& frame, const RigidTransform& fixed,
                  const RigidTransform& said);
  RigidTransform at(const Frame& frame, double stamp_s) const;

  std::map<std::string, Frame> frames_;  ///< By the child's name.
  std::size_t refused_ = 0;
  std::vector<Contradiction> contradictions_;
};

}  // namespace parloc
