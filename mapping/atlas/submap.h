// A submap (thesis 4.3.2): a rigid map of its own, in the frame of the keyframe that it began with.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "core/keyframe.h"
#include "mapping/atlas/overlap_cloud.h"
#include "mapping/atlas/paged_contents.h"
#include "mapping/atlas/submap_outline.h"
#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

/// What one part of a submap accumulated. Clouds of submaps that became one stay apart (thesis 4.7.3: never
/// combined), each in the frame that it grew in, so that fusion neither thins them nor lets one creep through
/// the next doorway.
struct AccumulatedCloud {
  core::Pose T_submap_cloud = core::Pose::Identity();
  OverlapCloud points;
};

struct HeldKeyframe {
  core::AnchoredPoint sensor;                          ///< where it was at the keyframe's first revolution
  core::Pose T_map_keyframe = core::Pose::Identity();  ///< as of the latest poses
};

class Submap {
 public:
  Submap(uint32_t number, core::KeyframeId root_keyframe, PagedContents empty, double filter_m);

  uint32_t id;                                       ///< counted from 0; never given again
  core::KeyframeId root;                             ///< the submap's frame is this keyframe's
  core::Pose T_map_submap = core::Pose::Identity();  ///< as of the latest poses
  std::vector<HeldKeyframe> keyframes;               ///< whose revolutions it holds, ascending
  PagedContents contents;
  std::vector<AccumulatedCloud> clouds;  ///< its own first
  std::set<uint32_t> beyond;             ///< ids of submaps from or to which the sensor passed a doorway
  double overlap = 0.0;   ///< of its root's cloud with the submap in use before (thesis Alg. 1)
  uint64_t latest = 0;    ///< the atlas's count of revolutions when this submap last took one
  uint64_t revision = 0;  ///< counts changes of `contents`

  /// To where its root lies; its keyframes to where they do.
  void MoveTo(const core::PoseSource& poses);

  /// Of the contents as they are; for any thread while nobody writes.
  std::shared_ptr<const SubmapOutline> Outline() const;

  /// The cloud that a keyframe's returns (in the map) overlap most, and the share (thesis Alg. 1); a share of
  /// 0 where none is above `above`.
  struct CloudMatch {
    double share = 0.0;
    size_t cloud = 0;
  };
  CloudMatch BestCloud(const std::vector<core::Vec3f>& cloud_map, double above = 0.0) const;
  void AddToCloud(size_t cloud, const std::vector<core::Vec3f>& cloud_map);

  /// Takes over what another submap holds; that one is to be thrown away (thesis 4.8).
  void Absorb(Submap* other);
  /// In memory.
  size_t Bytes() const;

 private:
  std::vector<core::Vec3f> InCloud(size_t cloud, const std::vector<core::Vec3f>& cloud_map) const;

  mutable std::mutex outline_mutex_;
  mutable std::shared_ptr<const SubmapOutline> outline_;
  mutable uint64_t outlined_ = 0;  ///< the revision that outline_ is of
};

}  // namespace atlas::mapping
