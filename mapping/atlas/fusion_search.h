// Which submaps are to become one (thesis 4.8, 4.9).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "mapping/atlas/atlas_params.h"
#include "mapping/atlas/submap.h"
#include "mapping/atlas/submap_overlap.h"

namespace atlas::mapping {

using Submaps = std::vector<std::unique_ptr<Submap>>;  ///< by ascending id

/// Proposals are remembered, so that what is dear is worked out again only where it may come out otherwise:
/// overlap where a submap took evidence or the two moved to each other past Eq. 4.5's thresholds, relative
/// uncertainty where poses changed.
class FusionSearch {
 public:
  explicit FusionSearch(const AtlasParams& params) : params_(params) {}

  /// The two, by their places in `submaps`, the older one first.
  using Pair = std::pair<size_t, size_t>;
  /// The two that overlap most of those that may become one by thesis 4.8.2, and are sure enough by 4.9.
  /// @param left_out  the id of a submap that is not to be looked at yet
  std::optional<Pair> NextByOverlap(const Submaps& submaps, const core::PoseSource& poses,
                                    std::optional<uint32_t> left_out);
  /// The first two with keyframes about one loop (thesis 4.8.1) that are sure enough.
  std::optional<Pair> NextByLoop(const Submaps& submaps, const core::PoseSource& poses);

  /// Whether two keyframes lie on one level, by `level_m`.
  bool OnOneLevel(core::KeyframeId a, core::KeyframeId b, const core::PoseSource& poses) const;
  /// Whether two keyframes are sure enough of each other for what hangs on them to become one (thesis 4.9).
  bool SureEnough(core::KeyframeId a, core::KeyframeId b, const core::PoseSource& poses) const;

 private:
  struct Estimate {
    uint64_t revision_a = 0, revision_b = 0;
    core::Pose T_a_b = core::Pose::Identity();
    SubmapOverlap overlap;            ///< of a, of b
    std::optional<uint64_t> refused;  ///< the version of poses that was not sure enough
  };
  using Ids = std::pair<uint32_t, uint32_t>;

  const SubmapOverlap& OverlapOfPair(const Submap& a, const Submap& b);
  bool Moved(const core::Pose& before, const core::Pose& now) const;
  bool InRange(const Submap& a, const Submap& b, const core::PoseSource& poses) const;
  /// Enough to become one, of two that a doorway separates or of others.
  bool Overlaps(const SubmapOverlap& overlap, bool separated) const;
  bool MayFuse(const Submap& a, const Submap& b, const core::PoseSource& poses);
  uint64_t KnownVoxelsOf(const Submap& submap);
  void Forget(const Submaps& submaps);

  AtlasParams params_;
  std::map<Ids, Estimate> estimates_;
  std::map<uint32_t, std::pair<uint64_t, uint64_t>> known_;  ///< revision and KnownVoxels, by id
  std::map<Ids, uint64_t> loop_tried_;                       ///< the version of poses
};

}  // namespace atlas::mapping
