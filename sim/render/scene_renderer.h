// Draws meshes off screen: colours with sun and shadow, or depth.
#pragma once

#include <memory>
#include <vector>

#include "sim/render/colored_mesh.h"
#include "sim/render/render_context.h"

namespace atlas::sim {

/// The camera frame is x right, y down, z forward; pixel centres at (u + 0.5, v + 0.5), principal point at
/// the centre, square pixels.
struct RenderCamera {
  core::Pose T_map_camera = core::Pose::Identity();
  double vertical_fov_rad = core::Radians(50.0);
  double near_m = 0.1;
  double far_m = 300.0;
};

/// A camera at `eye` that looks at `target`, with map z up. @pre they are not above one another.
core::Pose LookAt(const core::Vec3& eye, const core::Vec3& target);

struct RenderLight {
  core::Vec3 to_sun = core::Vec3(0.45, -0.35, 0.82);
  /// Shadows fall inside this ball; without a radius there are none.
  core::Vec3 shadow_center = core::Vec3::Zero();
  double shadow_radius_m = 0.0;
  Rgb sky = {206, 220, 234};
};

/// Meshes with poses in the map frame. Not thread-safe; use from one thread at a time.
class SceneRenderer {
 public:
  explicit SceneRenderer(std::shared_ptr<RenderContext> context);
  ~SceneRenderer();
  SceneRenderer(const SceneRenderer&) = delete;
  SceneRenderer& operator=(const SceneRenderer&) = delete;

  /// Returns the mesh's id: 0, 1, ... in order. It is drawn at the map's origin until SetPose. May be empty.
  int AddMesh(const ColoredMesh& mesh);
  /// Keeps pose and visibility.
  void ReplaceMesh(int id, const ColoredMesh& mesh);
  void SetPose(int id, const core::Pose& T_map_mesh);
  void SetVisible(int id, bool visible);

  /// `samples` per pixel smooth the edges (1, 2 or 4). @throws std::runtime_error for an unsupported size.
  RgbImage RenderRgb(const RenderCamera& camera, const RenderLight& light, int width, int height,
                     int samples = 1);
  /// Metres along the optical axis, row-major, top row first; infinity where nothing is before far_m.
  std::vector<float> RenderDepth(const RenderCamera& camera, int width, int height);

  const RenderContext& context() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::sim
