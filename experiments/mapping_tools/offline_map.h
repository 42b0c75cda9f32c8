// A map out of a recorded log: what `atlas map` does between reading scans and writing files.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/lidar_model.h"
#include "core/mesh.h"
#include "core/params.h"
#include "core/sensor_events.h"
#include "mapping/cloud/voxel_filter.h"
#include "mapping/integrator/integrator.h"
#include "mapping/io/map_file.h"

namespace atlas::experiments {

/// The section `mapper` of `--set`.
struct OfflineMapParams {
  std::string field = "occupancy";  ///< occupancy | tsdf
  double resolution_m = 0.065;
  /// A rolling map in the odometry frame, cropped to this about the LiDAR (thesis 4.6); 0: all is kept.
  double local_radius_m = 0.0;
  double cloud_spacing_m = 0.0;  ///< at most one point a cell of this size in the cloud; 0: the resolution
  mapping::IntegratorParams integrator;
  void Visit(core::ParamVisitor& v);
};

/// Hits in the map frame, each ray at its own time, at most one a cell.
class CloudBuilder {
 public:
  CloudBuilder(double spacing_m, double max_range_m) : filter_(spacing_m), max_range_m_(max_range_m) {}
  void Add(const core::SpinEvent& spin, const core::Pose& T_map_odom);
  const core::PointCloud& cloud() const { return cloud_; }
  /// Without what lies farther than `radius_m` from `center`.
  core::PointCloud Within(const core::Vec3& center, double radius_m) const;

 private:
  mapping::VoxelFilter filter_;
  double max_range_m_;
  core::PointCloud cloud_;
};

/// Known space by volume.
struct MapVolume {
  double free_m3 = 0.0;
  double occupied_m3 = 0.0;
};
MapVolume VolumeOf(const mapping::AnyOctree& map);

/// Erases the chunks that lie farther than `radius_m` from `center` (thesis 4.6).
template <typename Field>
void CropAround(const core::Vec3& center, double radius_m, mapping::Octree<Field>* map);

/// Integrates scans one after another into an octree of either field.
class OfflineMapper {
 public:
  /// @param lidar  the beams of organised scans; none: scans are cast ray by ray.
  OfflineMapper(const OfflineMapParams& params, const std::optional<core::LidarModel>& lidar);
  ~OfflineMapper();

  /// `T_map_odom` places the log in the map. Points of the cloud and the crop follow.
  void Add(const core::SpinEvent& spin, const core::Pose& T_map_odom);

  const mapping::AnyOctree& map() const;
  size_t MapBytes() const;
  /// Of the whole way, or of the rolling map's reach.
  core::PointCloud Cloud() const;
  /// Of the last scan.
  const mapping::IntegrationStats& stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::experiments
