// The Atlas: submaps, each rigid, on keyframes that move (thesis 4.7, 4.8).
//
//     keyframes   k0 ── k1 ── k2 ── k3 ── k4 ── k5 ──    a revolution belongs to a keyframe,
//                 └──────────┘    └──────────┘   │       a keyframe to a submap;
//     submaps      S0 (root k0)    S1 (root k3)  │       a submap lies where its root does;
//                  └─────────────────────────────┘       one that fits again is taken up again,
//                                                        and two that measured the same become one
//
// A revolution goes straight into its keyframe's submap, once, where poses put it at that time: what the
// submap holds is rigid from then on. A correction moves roots and touches no voxel.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/keyframe.h"
#include "mapping/atlas/atlas_params.h"
#include "mapping/atlas/atlas_view.h"
#include "mapping/atlas/doorway_watch.h"
#include "mapping/atlas/fusion_search.h"
#include "mapping/atlas/saved_atlas.h"
#include "mapping/atlas/submap.h"
#include "mapping/integrator/integrator.h"
#include "mapping/map.h"

namespace atlas::mapping {

struct AtlasSetup {
  double resolution_m = 0.05;
  IntegratorParams integrator;
  MapSetup map;
  double behind_surface_m = 0.3;  ///< where the setup keeps such marks
};

class Atlas {
 public:
  /// @throws InputError where what it goes on from has voxels of another size.
  Atlas(const AtlasParams& params, const AtlasSetup& setup);
  ~Atlas();

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses);
  /// Moves submaps to where their roots lie. Where poses have changed, submaps that overlap by now, and those
  /// that now are sure enough of each other, become one.
  void Correct(const core::PoseSource& poses);
  std::shared_ptr<const AtlasView> Snapshot() const;
  const Submaps& submaps() const { return submaps_; }
  /// What is to be saved, as of now.
  SavedAtlas Saved() const;
  /// In memory.
  size_t Bytes() const;
  const ContentsPager& pager() const { return *pager_; }

 private:
  void GoOnFrom(const SavedAtlas& earlier);
  std::vector<const Submap*> ByPrecedence() const;
  struct NewKeyframe;
  /// Gives what begins with a revolution to the submap in use, or to an older or a new one (thesis 4.7.1,
  /// 4.7.3): a new keyframe, or what of one lies beyond a doorway.
  void Assign(const core::AnchoredSpin& spin, bool beyond_doorway, const core::PoseSource& poses);
  void TakeUp(Submap* next, bool beyond_doorway, const core::PoseSource& poses);
  /// The submap that the keyframe overlaps most and is sure enough of; null where there is none.
  Submap* Fitting(const NewKeyframe& keyframe, bool active_too, const core::PoseSource& poses) const;
  Submap* Spawn(core::KeyframeId root, const core::PoseSource& poses);
  void Activate(Submap* submap);
  void Fill(const core::AnchoredSpin& spin, const core::Pose& T_submap_odom, OctreeContents* contents);
  /// Until no two are left that should be one.
  void Fuse(const core::PoseSource& poses, std::optional<uint32_t> left_out);
  PagedContents Empty() const;

  AtlasParams params_;
  AtlasSetup setup_;
  std::shared_ptr<ContentsPager> pager_;
  Submaps submaps_;
  uint32_t next_id_ = 0;
  FusionSearch search_;
  Submap* active_ = nullptr;
  /// Of the active submap: one of the two, by its field.
  std::unique_ptr<ScanIntegrator<OccupancyField>> integrator_;
  std::unique_ptr<ScanIntegrator<TsdfField>> distance_integrator_;
  std::optional<core::AnchoredPoint> keyframe_;  ///< of the latest revolution; where the sensor was first
  double travelled_m_ = 0.0;                     ///< along keyframes, since the active submap was taken up
  DoorwayWatch doorways_;
  std::set<uint32_t> same_side_;  ///< ids of submaps in use since a doorway was passed last
  bool by_doorway_ = false;       ///< the active submap was taken up
  uint64_t revolutions_ = 0;
  std::optional<uint64_t> version_;  ///< of the poses that submaps lie by
  UndistortedSpin rays_;
};

}  // namespace atlas::mapping
