// Keyframes that lie where a test puts them.
#pragma once

#include <utility>
#include <vector>

#include "core/keyframe.h"

namespace atlas::tests {

/// Keyframes that a test moves at will; the youngest one is the last.
class MovedKeyframes : public core::PoseSource {
 public:
  explicit MovedKeyframes(std::vector<core::Pose> T_map_keyframe = {core::Pose::Identity()},
                          uint64_t version = 0)
      : T_map_keyframe_(std::move(T_map_keyframe)), version_(version) {}
  core::Pose T_map_keyframe(core::KeyframeId keyframe) const override { return T_map_keyframe_.at(keyframe); }
  uint64_t version() const override { return version_; }
  core::KeyframeId latest() const override {
    return static_cast<core::KeyframeId>(T_map_keyframe_.size() - 1);
  }
  std::optional<double> RelativeSigmaM(core::KeyframeId a, core::KeyframeId b) const override {
    return a == b ? std::optional(0.0) : sigma_m;
  }
  const std::vector<std::pair<core::KeyframeId, core::KeyframeId>>& Loops() const override { return loops; }

  std::optional<double> sigma_m;  ///< between any two
  std::vector<std::pair<core::KeyframeId, core::KeyframeId>> loops;

 private:
  std::vector<core::Pose> T_map_keyframe_;
  uint64_t version_;
};

}  // namespace atlas::tests
