#include "common/slam/path_tree.h"

#include <algorithm>

#include "common/slam/checkpoint_values.h"

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

// Only what is in use, parents before children: then a parent's place is known when a child comes.
void PathTree::save(ByteWriter& w) const {
  std::vector<bool> dead(node_.size(), false);
  for (const std::uint32_t at : free_) dead[at] = true;
  std::vector<std::uint32_t> order;
  for (std::uint32_t at = 0; at < node_.size(); ++at)
    if (!dead[at]) order.push_back(at);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return node_[a].step < node_[b].step; });
  std::vector<std::uint32_t> place(node_.size(), kNone);
  for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;
  const auto place_of = [&](std::uint32_t at) { return at == kNone ? kNone : place[at]; };
  w.put(steps_);
  w.put_each(order, [&](ByteWriter& out, std::uint32_t at) {
    out.put(place_of(node_[at].parent));
    put_pose(out, node_[at].pose);
  });
  for (const std::uint32_t at : tip_) w.put(place_of(at));
}

void PathTree::load(ByteReader& r, const std::function<bool(const Pose&)>& on_map) {
  free_.clear();
  steps_ = r.get<std::uint32_t>();
  node_ = r.get_each(28, [](ByteReader& in) {
    const auto parent = in.get<std::uint32_t>();
    return Node{parent, 0, 0, get_pose(in)};
  });
  for (std::size_t k = 0; k < node_.size(); ++k) {
    Node& node = node_[k];
    r.expect(on_map(node.pose), "ways on the map");
    if (node.parent == kNone) continue;
    r.expect(node.parent < k, "ways whose beginning comes first");
    node.step = node_[node.parent].step + 1;
    ++node_[node.parent].children;
  }
  for (std::uint32_t& at : tip_) {
    at = r.get<std::uint32_t>();
    const bool sound = steps_ == 0 ? at == kNone : at < node_.size() && node_[at].step + 1 == steps_;
    r.expect(sound, "a way of every particle");
  }
  for (const Node& node : node_) r.expect(node.step < steps_, "ways of so many steps");
}

}  // namespace parloc
