#include "mapping/io/bag_transforms.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors.h"
#include "mapping/io/bag_messages.h"

namespace atlas::mapping {
namespace {

using core::Pose;

/// A transform between moments farther apart is not interpolated.
constexpr double kLongestGap_s = 1.0;

void SortByTime(RecordedPoses* poses) {
  std::vector<size_t> order(poses->size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return poses->time_s[a] < poses->time_s[b]; });
  RecordedPoses sorted;
  for (const size_t i : order) {
    sorted.time_s.push_back(poses->time_s[i]);
    sorted.T_map_lidar.push_back(poses->T_map_lidar[i]);
  }
  *poses = std::move(sorted);
}

}  // namespace

std::string FrameName(const std::string& frame) {
  std::string name = frame.starts_with('/') ? frame.substr(1) : frame;
  for (char& c : name) c = c > ' ' && c < 127 ? c : '?';
  return name;
}

BagTransforms::BagTransforms(const BagFile& bag, const std::string& file, const std::string& moving_topic)
    : file_(file) {
  for (const BagConnection& c : bag.connections()) {
    const bool is_static = c.topic.ends_with("tf_static");
    if (!IsTransformsType(c.type) || (!is_static && c.topic != moving_topic)) continue;
    for (const BagMessage& m : bag.MessagesOf({c.id})) {
      for (const BagPose& T : ParseTransformsMessage(bag.Read(m), file + ": " + c.topic)) {
        const auto [it, added] = edge_of_child_.try_emplace(FrameName(T.child_frame));
        Edge& edge = it->second;
        if (added) edge = {FrameName(T.frame), {}, is_static};
        if (edge.parent != FrameName(T.frame) || (edge.is_static && !added)) continue;
        edge.T_parent_child.time_s.push_back(is_static ? 0.0 : T.stamp_s);
        edge.T_parent_child.T_map_lidar.push_back(T.pose);
      }
    }
  }
  for (auto& [child, edge] : edge_of_child_) SortByTime(&edge.T_parent_child);
}

std::optional<Pose> BagTransforms::Static(const std::string& from, const std::string& to) const {
  std::map<std::string, Pose> T_from = {{from, Pose::Identity()}};
  for (size_t known = 0; known != T_from.size();) {
    known = T_from.size();
    for (const auto& [child, edge] : edge_of_child_) {
      if (!edge.is_static) continue;
      const Pose& T_parent_child = edge.T_parent_child.T_map_lidar[0];
      const bool has_parent = T_from.count(edge.parent) != 0, has_child = T_from.count(child) != 0;
      if (has_parent && !has_child) T_from[child] = T_from[edge.parent] * T_parent_child;
      if (has_child && !has_parent) T_from[edge.parent] = T_from[child] * T_parent_child.inverse();
    }
  }
  const auto found = T_from.find(to);
  return found == T_from.end() ? std::nullopt : std::optional(found->second);
}

std::vector<const BagTransforms::Edge*> BagTransforms::ToRoot(std::string frame, std::string* root) const {
  std::vector<const Edge*> edges;
  for (auto it = edge_of_child_.find(frame); it != edge_of_child_.end(); it = edge_of_child_.find(frame)) {
    if (edges.size() == edge_of_child_.size())
      throw core::InputError(fmt::format("{}: the transforms above frame '{}' go round", file_, frame));
    edges.push_back(&it->second);
    frame = it->second.parent;
  }
  *root = frame;
  return edges;
}

RecordedPoses BagTransforms::OfFrame(const std::string& frame) const {
  std::string root;
  const std::vector<const Edge*> edges = ToRoot(frame, &root);
  const Edge* densest = nullptr;
  for (const Edge* edge : edges) {
    if (edge->is_static) continue;
    if (densest == nullptr || edge->T_parent_child.size() > densest->T_parent_child.size()) densest = edge;
  }
  if (densest == nullptr)
    throw core::InputError(fmt::format("{}: no transform moves the clouds' frame '{}'", file_, frame));
  RecordedPoses poses;
  for (const double time_s : densest->T_parent_child.time_s) {
    Pose T_root_frame = Pose::Identity();
    bool known = true;
    for (const Edge* edge : edges) {
      const auto T = edge->is_static ? std::optional(edge->T_parent_child.T_map_lidar[0])
                                     : PoseNear(edge->T_parent_child, time_s, kLongestGap_s);
      known &= T.has_value();
      if (T) T_root_frame = *T * T_root_frame;
    }
    if (!known) continue;
    poses.time_s.push_back(time_s);
    poses.T_map_lidar.push_back(T_root_frame);
  }
  if (poses.size() == 0)
    throw core::InputError(
        fmt::format("{}: the transforms from '{}' to '{}' share no moment", file_, root, frame));
  poses.note = fmt::format("{} in {}", frame, root);
  return poses;
}

}  // namespace atlas::mapping
