// Keyframes that never move once they are made.
#pragma once

#include <cassert>
#include <memory>
#include <vector>

#include "core/keyframe.h"

namespace atlas::mapping {

class FixedPoses : public core::PoseSource {
 public:
  explicit FixedPoses(std::vector<core::Pose> T_map_keyframe) : T_map_keyframe_(std::move(T_map_keyframe)) {}
  core::Pose T_map_keyframe(core::KeyframeId keyframe) const override {
    assert(keyframe < T_map_keyframe_.size());
    return T_map_keyframe_[keyframe];
  }
  uint64_t version() const override { return 0; }
  core::KeyframeId latest() const override {
    assert(!T_map_keyframe_.empty());
    return static_cast<core::KeyframeId>(T_map_keyframe_.size() - 1);
  }

 private:
  std::vector<core::Pose> T_map_keyframe_;
};

}  // namespace atlas::mapping
