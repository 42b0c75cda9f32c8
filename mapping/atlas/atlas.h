// The Atlas: submaps, each rigid, on keyframes that move (thesis 4.7).
//
//     keyframes   k0 ── k1 ── k2 ── k3 ── k4 ──    a revolution belongs to a keyframe,
//                 └──────────┘    └──────────┘     a keyframe to a submap;
//     submaps      S0 (root k0)    S1 (root k3)    a submap lies where its root does
//
// A revolution goes straight into its keyframe's submap, once, where poses put it at that time: what the
// submap holds is rigid from then on. A correction moves roots and touches no voxel.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/keyframe.h"
#include "mapping/atlas/atlas_params.h"
#include "mapping/atlas/atlas_view.h"
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
  Atlas(const AtlasParams& params, const AtlasSetup& setup);
  ~Atlas();

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses);
  void Correct(const core::PoseSource& poses);
  std::shared_ptr<const AtlasView> Snapshot() const;
  const std::vector<std::unique_ptr<Submap>>& submaps() const { return submaps_; }
  size_t Bytes() const;

 private:
  /// Gives a new keyframe to the submap in use, or to a new one (thesis 4.7.1, 4.7.3).
  void Assign(const core::AnchoredSpin& spin, const core::PoseSource& poses);
  void Spawn(core::KeyframeId root, const core::PoseSource& poses);
  OctreeContents Empty() const;

  AtlasParams params_;
  AtlasSetup setup_;
  std::vector<std::unique_ptr<Submap>> submaps_;
  Submap* active_ = nullptr;
  std::unique_ptr<ScanIntegrator<OccupancyField>> integrator_;  ///< of the active submap
  std::optional<core::KeyframeId> keyframe_;                    ///< of the latest revolution
  core::AnchoredPoint latest_place_;                            ///< of the sensor at that keyframe's first
  double travelled_m_ = 0.0;                                    ///< along keyframes, in the active submap
  uint64_t revolutions_ = 0;
  UndistortedSpin rays_;
};

}  // namespace atlas::mapping
