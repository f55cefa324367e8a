#include "common/slam/path_tree.h"

namespace parloc {

std::uint32_t PathTree::make(const Node& node) {
  if (free_.empty()) {
    node_.push_back(node);
    return static_cast<std::uint32_t>(node_.size() - 1);
  }
  const std::uint32_t at = free_.back();
  free_.pop_back();
  node_[at] = node;
  return at;
}

void PathTree::drop(std::uint32_t at) {
  while (at != kNone && node_[at].children == 0) {
    const std::uint32_t parent = node_[at].parent;
    free_.push_back(at);
    if (parent != kNone) --node_[parent].children;
    at = parent;
  }
}

void PathTree::add(const std::vector<Pose>& poses, const std::vector<std::uint32_t>& ancestor) {
  std::vector<std::uint32_t> tip(poses.size());
  for (std::size_t j = 0; j < poses.size(); ++j) {
    const std::uint32_t parent = tip_[ancestor[j]];
    tip[j] = make({parent, 0, steps_, poses[j]});
    if (parent != kNone) ++node_[parent].children;
  }
  for (const std::uint32_t old : tip_) drop(old);
  tip_ = tip;
  ++steps_;
}

std::vector<Pose> PathTree::path(std::size_t particle) const {
  std::vector<Pose> out(steps_);
  for (std::uint32_t at = tip_[particle]; at != kNone; at = node_[at].parent)
    out[node_[at].step] = node_[at].pose;
  return out;
}

std::vector<std::size_t> PathTree::distinct() const {
  std::vector<bool> dead(node_.size(), false);
  for (const std::uint32_t at : free_) dead[at] = true;
  std::vector<std::size_t> count(steps_, 0);
  for (std::size_t at = 0; at < node_.size(); ++at)
    if (!dead[at]) ++count[node_[at].step];
  return count;
}

}  // namespace parloc
