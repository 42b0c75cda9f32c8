// Ray casting against labelled meshes with Embree.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/mesh.h"
#include "scenes/scene_spec.h"

namespace atlas::sim {

struct RayHit {
  float range_m = -1.0f;  ///< < 0: nothing within max range
  int32_t part = -1;      ///< index into SceneSpec::parts; -1 none; >= 0x40000000: moving body (id below)
  core::Vec3f normal = core::Vec3f::Zero();  ///< geometric, not normalised; filled where asked for
};
constexpr int32_t kMovingBody = 0x40000000;

/// Static scene plus rigid moving bodies. Casting is const and thread-safe once poses are committed.
class Raycaster {
 public:
  explicit Raycaster(const scenes::SceneSpec& scene);
  ~Raycaster();
  Raycaster(Raycaster&&) noexcept;

  /// Adds a rigid body; returns its index (hits carry kMovingBody + index). Call before CommitPoses.
  int AddBody(const core::TriMesh& mesh_body);
  void SetBodyPose(int body, const core::Pose& T_map_body);
  /// Makes poses set since the last commit visible to casts; does nothing where there are none.
  void CommitPoses();

  /// Whether `p_map` lies within `margin_m` of a body's surface (its triangles, as committed or not).
  bool NearBody(const core::Vec3& p_map, double margin_m) const;
  /// No point of any body is farther than this from `p_map`; 0 without bodies.
  double BodyReach(const core::Vec3& p_map) const;

  /// Nearest hit of each ray within (0, max_range_m]. Partly transmissive parts stop a share of the rays,
  /// chosen by hashing (`transmission_seed`, ray index), so results repeat.
  void Cast(std::span<const core::Ray> rays, float max_range_m, uint64_t transmission_seed, int threads,
            std::span<RayHit> hits) const;
  /// As Cast, against the static scene only and as if every part were opaque.
  void CastStatic(std::span<const core::Ray> rays, float max_range_m, int threads,
                  std::span<RayHit> hits) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::sim
