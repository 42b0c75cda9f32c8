// Keyframes that are the nodes of a pose graph, as it was solved at one moment.
#pragma once

#include <cassert>
#include <vector>

#include "core/keyframe.h"

namespace atlas::mapping {

class GraphPoses final : public core::PoseSource {
 public:
  GraphPoses(std::vector<core::Pose> T_map_node, uint64_t version)
      : T_map_node_(std::move(T_map_node)), version_(version) {}
  core::Pose T_map_keyframe(core::KeyframeId keyframe) const override {
    assert(keyframe < T_map_node_.size());
    return T_map_node_[keyframe];
  }
  uint64_t version() const override { return version_; }
  core::KeyframeId latest() const override { return static_cast<core::KeyframeId>(T_map_node_.size() - 1); }

 private:
  std::vector<core::Pose> T_map_node_;
  uint64_t version_;
};

}  // namespace atlas::mapping
