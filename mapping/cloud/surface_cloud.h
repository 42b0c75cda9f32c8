// A cloud made ready for registration: one point a voxel, each with the normal of the surface through it, and
// a kd-tree.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

struct SurfaceCloudParams {
  double voxel_m =
      0.0;  ///< side of the cells that keep their mean point; 0: by the cloud's extent (ChooseVoxel)
  int neighbours = 12;  ///< points, itself included, that a normal is fitted to, within 3 voxels; at least 5
  int threads = 1;      ///< results do not depend on it
  core::Vec3f viewpoint = core::Vec3f::Zero();  ///< normals face it: where the sensor was
};

/// A side at which rooms and streets alike leave some thousands of points: a fortieth of the median distance
/// from `viewpoint`, 0.1 to 0.5 m.
double ChooseVoxel(std::span<const core::Vec3f> points, const core::Vec3f& viewpoint);

/// The mean of the points in each cell of a grid, by the order in which cells are met. Points that are not
/// finite are left out. `first`, if given, takes the index of the first point in each cell.
/// @pre voxel_m > 0, |p| < 2^20 cells.
std::vector<core::Vec3f> ThinToVoxels(std::span<const core::Vec3f> points, double voxel_m,
                                      std::vector<uint32_t>* first = nullptr);

/// Immutable; any thread may search it. May be moved.
class SurfaceCloud {
 public:
  SurfaceCloud(std::span<const core::Vec3f> points, const SurfaceCloudParams& params);
  SurfaceCloud(SurfaceCloud&&) noexcept;
  SurfaceCloud& operator=(SurfaceCloud&&) noexcept;
  ~SurfaceCloud();

  size_t size() const { return points().size(); }
  const std::vector<core::Vec3f>& points() const;
  /// Unit, facing the viewpoint; zero where the neighbours lie on a line (one row of the LiDAR), on no plane,
  /// are too few, or where the surfaces around are turned otherwise.
  const std::vector<core::Vec3f>& normals() const;
  /// Of each point, the index of the first given one in its cell.
  const std::vector<uint32_t>& first_in_cell() const;
  double voxel_m() const;

  /// The nearest point strictly within `max_distance_m` of `p`, or -1.
  int64_t Nearest(const core::Vec3f& p, float max_distance_m) const;

 private:
  struct Impl;  // holds the kd-tree, which refers to the points: it must not move
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::mapping
