// Keyframes that never move once they are made.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "core/keyframe.h"

namespace atlas::mapping {

class FixedPoses : public core::PoseSource {
 public:
  /// @param sigma_m  of a keyframe's position, each axis, on its own; absent: not known
  explicit FixedPoses(const std::vector<core::Pose>& T_map_keyframe, std::optional<double> sigma_m = {})
      : FixedPoses(Copied(T_map_keyframe.data(), T_map_keyframe.size(), T_map_keyframe.size()),
                   T_map_keyframe.size(), sigma_m) {}
  core::Pose T_map_keyframe(core::KeyframeId keyframe) const override {
    assert(keyframe < count_);
    return T_map_keyframe_[keyframe];
  }
  uint64_t version() const override { return 0; }
  core::KeyframeId latest() const override {
    assert(count_ > 0);
    return static_cast<core::KeyframeId>(count_ - 1);
  }
  std::optional<double> RelativeSigmaM(core::KeyframeId a, core::KeyframeId b) const override {
    if (a == b) return 0.0;
    return sigma_m_ ? std::optional(std::sqrt(2.0) * *sigma_m_) : std::nullopt;
  }

 private:
  friend class KeyframeList;
  using Poses = std::shared_ptr<core::Pose[]>;
  FixedPoses(std::shared_ptr<const core::Pose[]> T_map_keyframe, size_t count, std::optional<double> sigma_m)
      : T_map_keyframe_(std::move(T_map_keyframe)), count_(count), sigma_m_(sigma_m) {}
  /// Room for `capacity` poses, the first `count` of them copied.
  static Poses Copied(const core::Pose* poses, size_t count, size_t capacity) {
    Poses room = std::make_shared<core::Pose[]>(capacity);
    std::copy(poses, poses + count, room.get());
    return room;
  }

  std::shared_ptr<const core::Pose[]> T_map_keyframe_;  ///< others may be written behind the first count_
  size_t count_;
  std::optional<double> sigma_m_;
};

/// Grows by one keyframe at a time; snapshots share what they hold, for any thread, and copy nothing. Poses
/// are written behind all that a snapshot reads, so that keyframe and snapshot cost the same however many
/// came before.
class KeyframeList {
 public:
  /// @param sigma_m  as of FixedPoses
  explicit KeyframeList(std::optional<double> sigma_m = {}) : sigma_m_(sigma_m) {}
  void Add(const core::Pose& T_map_keyframe) {
    if (count_ == capacity_) {
      capacity_ = std::max<size_t>(16, 2 * capacity_);
      poses_ = FixedPoses::Copied(poses_.get(), count_, capacity_);
    }
    poses_[count_++] = T_map_keyframe;
  }
  size_t size() const { return count_; }
  std::shared_ptr<const FixedPoses> Snapshot() const {
    return std::shared_ptr<const FixedPoses>(new FixedPoses(poses_, count_, sigma_m_));
  }

 private:
  FixedPoses::Poses poses_;
  size_t count_ = 0, capacity_ = 0;
  std::optional<double> sigma_m_;
};

}  // namespace atlas::mapping
