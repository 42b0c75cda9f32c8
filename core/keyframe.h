// Places that survive a correction of the map: they are kept relative to keyframes, and posed when they are
// read.
//
//        map ──T_map_keyframe──> keyframe ──T_keyframe_here──> the place
//            (a PoseSource's,       (an Anchor's,
//             changes when the       never changes)
//             map is corrected)
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry.h"
#include "core/sensor_events.h"

namespace atlas::core {

/// Counted from 0 in the order in which a localiser made them.
using KeyframeId = uint32_t;

/// Where keyframes lie in the map, as known at one moment. Immutable, and so for any thread.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  /// @pre the keyframe existed when this was taken.
  virtual Pose T_map_keyframe(KeyframeId keyframe) const = 0;
  /// Greater than that of any source before it in which a keyframe lay elsewhere. A new keyframe alone does
  /// not change it.
  virtual uint64_t version() const = 0;
  /// The youngest keyframe. @pre there is one.
  virtual KeyframeId latest() const = 0;

  /// How sure it is where the one lies to the other: the greatest standard deviation of the translation of
  /// T_a_b, m (thesis 4.9, Eq. 4.13). Nothing where that is not known: odometry alone, which nobody corrects.
  /// @pre both exist.
  virtual std::optional<double> RelativeSigmaM(KeyframeId a, KeyframeId b) const {
    return a == b ? std::optional(0.0) : std::nullopt;
  }
  /// Keyframes that were recognised as one place, each older one first. Changes with version() alone.
  virtual const std::vector<std::pair<KeyframeId, KeyframeId>>& Loops() const {
    static const std::vector<std::pair<KeyframeId, KeyframeId>> kNone;
    return kNone;
  }
};

/// A place, kept relative to a keyframe.
struct Anchor {
  KeyframeId keyframe = 0;
  Pose T_keyframe_here = Pose::Identity();

  Pose T_map_here(const PoseSource& poses) const { return poses.T_map_keyframe(keyframe) * T_keyframe_here; }
};

/// A point, kept relative to a keyframe.
struct AnchoredPoint {
  KeyframeId keyframe = 0;
  Vec3 p_keyframe = Vec3::Zero();

  /// Of a point found now: the youngest keyframe is the nearest in time.
  static AnchoredPoint At(const Vec3& p_map, const PoseSource& poses) {
    const KeyframeId keyframe = poses.latest();
    return {keyframe, poses.T_map_keyframe(keyframe).inverse() * p_map};
  }
  Vec3 p_map(const PoseSource& poses) const { return poses.T_map_keyframe(keyframe) * p_keyframe; }
};

/// A revolution, and where in the map it belongs: odometry is smooth while it lasts, so one pose of the
/// odometry's frame moves all of it.
struct AnchoredSpin {
  std::shared_ptr<const SpinEvent> spin;
  KeyframeId keyframe = 0;
  Pose T_keyframe_odom = Pose::Identity();

  Pose T_map_odom(const PoseSource& poses) const { return poses.T_map_keyframe(keyframe) * T_keyframe_odom; }
};

}  // namespace atlas::core
