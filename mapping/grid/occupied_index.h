// The occupied voxels of a map, found by place.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

/// Centres of occupied voxels in buckets of half a metre.
class OccupiedIndex {
 public:
  /// No voxel. All that Build() brings lies in `region`.
  explicit OccupiedIndex(const core::Box3& region);

  void Build(std::vector<core::Vec3f> centers);
  const std::vector<core::Vec3f>& centers() const { return centers_; }
  /// To the nearest centre, at most `limit_m`.
  double DistanceTo(const core::Vec3& p_map, double limit_m) const;

 private:
  size_t BucketOf(const core::Vec3f& p) const;

  core::Box3 region_;
  std::array<int, 3> size_;  ///< buckets along each axis
  std::vector<core::Vec3f> centers_;
  std::vector<uint32_t> begin_;      ///< of each bucket in sorted_, and the end
  std::vector<core::Vec3f> sorted_;  ///< centres by bucket
};

}  // namespace atlas::mapping
