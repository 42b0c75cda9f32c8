// A depth camera (of the RealSense D435's kind) that renders the same labelled meshes as the LiDAR meets.
#pragma once

#include <memory>
#include <string>

#include "core/mesh.h"
#include "core/rng.h"
#include "core/sensor_events.h"
#include "scenes/scene_spec.h"

namespace atlas::sim {

struct DepthCameraModel {
  int width = 212;
  int height = 120;
  double hfov_rad = core::Radians(87.0);
  double min_depth_m = 0.2;
  double max_depth_m = 3.0;
  double sigma_per_m2 = 0.002;  ///< noise grows with depth squared: sigma = sigma_per_m2 z^2
};

/// Renders depth off screen. The camera frame is x right, y down, z forward. Not thread-safe; use from one
/// thread at a time (any thread).
class DepthCamera {
 public:
  /// Uploads the scene. Where no renderer is to be had the camera is unavailable, see `available()`.
  DepthCamera(const scenes::SceneSpec& scene, const DepthCameraModel& model, const core::Rng& rng);
  ~DepthCamera();
  DepthCamera(DepthCamera&&) noexcept;

  bool available() const;
  std::string backend() const;          ///< "egl", "osmesa" or "none"
  std::string why_unavailable() const;  ///< one line; empty where available

  /// Adds a rigid body of the robot; returns its index (0, 1, ... in order). Bodies start at the map's
  /// origin.
  int AddBody(const core::TriMesh& mesh_body);
  void SetBodyPose(int body, const core::Pose& T_map_body);

  /// One image from `T_map_camera`. NaN nearer than min_depth_m, beyond max_depth_m, where nothing is, and on
  /// the robot's own bodies, which hide what is behind them. The n-th capture of one seed always carries the
  /// same noise. @pre available()
  core::DepthImage Capture(const core::Pose& T_map_camera);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::sim
