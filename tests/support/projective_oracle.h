// What scans of a shape leave in an octree, voxel by voxel, with the shape's true normals and no shortcut:
// the plain reading of thesis 4.5.2, against which fast integrators and meshes of scans can be judged.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/lidar_model.h"
#include "core/sensor_events.h"
#include "mapping/integrator/write/occupancy_shift.h"
#include "mapping/octree/octree.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/field_of_shape.h"

namespace atlas::tests {

struct OracleParams {
  double sigma_min_m = 0.015, lambda_sigma = 0.0005, lambda_r = 0.02;
  double behind_min_voxels = 1.5, behind_max_m = 0.25, void_range_m = 20.0;
  double miss_units = 8.0;  ///< -L_min a scan, in steps of the field
  double truncation_voxels = 3.0;
};

/// A voxel's centre as one ray saw it.
struct Sighting {
  double distance_m = 0.0;  ///< to the surface along its normal, positive in front; infinite on void rays
  double past_m = 0.0;      ///< beyond the return, along the ray
  double range_m = 0.0;
  core::Vec3 normal = core::Vec3::UnitZ();
};

/// By the ray nearest to the voxel; none outside the field of view, on void rays beyond their trust, and on
/// void rays beside a return. @pre elevations are even, as those of the built-in models are.
inline std::optional<Sighting> SightOf(const core::Vec3& p_lidar, const core::SpinEvent& spin,
                                       const core::LidarModel& lidar, const AnalyticShape& shape,
                                       const OracleParams& params) {
  const core::LidarScan& scan = spin.scan;
  const core::Pose& T_map_lidar = spin.T_odom_lidar.poses().front().T;
  const double length = p_lidar.norm(), first = lidar.elevation_rad.front(),
               last = lidar.elevation_rad.back();
  const auto row =
      std::lround((std::asin(p_lidar.z() / length) - first) / (last - first) * (lidar.rows() - 1));
  if (row < 0 || row >= lidar.rows()) return std::nullopt;
  const double azimuth =
      std::atan2(p_lidar.y(), p_lidar.x()) - lidar.azimuth_offset_rad[static_cast<size_t>(row)];
  const auto column = std::lround(azimuth / lidar.StepRad());
  const auto ray_at = [&](long r, long c) {
    const long columns = lidar.columns;
    return static_cast<size_t>(std::clamp<long>(r, 0, lidar.rows() - 1) * columns +
                               (c % columns + columns) % columns);
  };
  const size_t ray = ray_at(row, column);
  Sighting seen;
  if (scan.kind[ray] == core::ReturnKind::kVoid) {
    for (int i = 0; i < 9; ++i) {
      if (scan.kind[ray_at(row + i % 3 - 1, column + i / 3 - 1)] != core::ReturnKind::kVoid)
        return std::nullopt;
    }
    if (length > params.void_range_m) return std::nullopt;
    seen.distance_m = std::numeric_limits<double>::infinity();
    seen.range_m = params.void_range_m;
    return seen;
  }
  const core::Vec3 direction = T_map_lidar.linear() * scan.direction_lidar[ray].cast<double>();
  seen.range_m = static_cast<double>(scan.range_m[ray]);
  seen.normal = shape.Normal(T_map_lidar.translation() + seen.range_m * direction);
  seen.past_m = length - seen.range_m;
  seen.distance_m = -seen.past_m * std::abs(seen.normal.dot(direction));
  return seen;
}

/// Eq. 4.2 about the surface moved by OccupancyShift.
inline mapping::OccupancyField::Value Updated(mapping::OccupancyField::Value old, const Sighting& seen,
                                              double resolution_m, const OracleParams& params) {
  using Field = mapping::OccupancyField;
  const double reach_m = std::clamp(params.lambda_r * seen.range_m, params.behind_min_voxels * resolution_m,
                                    params.behind_max_m);
  const double support_m = mapping::OccupancyShift(seen.normal, resolution_m);
  const double inside_m = support_m - seen.distance_m;
  if (inside_m > reach_m || seen.past_m > reach_m) return old;
  const double ramp_m = 3.0 * std::max(params.sigma_min_m, params.lambda_sigma * seen.range_m);
  const double evidence = params.miss_units * std::clamp(inside_m / ramp_m, -1.0, 0.5 * reach_m / ramp_m);
  // Of what is occupied the place comes apart, and goes a quarter of the voxel at a time.
  const double behind = inside_m / (2.0 * support_m);
  if (old <= 0) return OccupancyAt(old + std::lround(evidence), behind);
  const double place = Field::PlaceOf(old);
  const double moved =
      place + 0.25 * (evidence > 0.0 ? (behind > place + 0.125) - (behind < place - 0.125) : 0);
  return OccupancyAt(old / 4 * 4 + 4 * std::lround(evidence / 4.0), moved);
}

/// The mean of truncated distances.
inline mapping::TsdfField::Value Updated(mapping::TsdfField::Value old, const Sighting& seen,
                                         double resolution_m, const OracleParams& params) {
  using Field = mapping::TsdfField;
  const double truncation_m = params.truncation_voxels * resolution_m;
  if (seen.distance_m < -truncation_m || seen.past_m > truncation_m) return old;
  const double units = std::min(seen.distance_m, truncation_m) / Field::UnitM(resolution_m);
  const double mean = (old.distance * static_cast<double>(old.weight) + units) / (old.weight + 1.0);
  return {static_cast<int16_t>(std::lround(mean)),
          static_cast<uint8_t>(std::min(old.weight + 1, Field::kMaxWeight))};
}

/// Integrates one revolution, taken at rest, into the voxels of `region`.
template <typename Field>
void IntegratePlainly(const core::SpinEvent& spin, const core::LidarModel& lidar, const AnalyticShape& shape,
                      const core::Box3& region, const OracleParams& params, mapping::Octree<Field>* map) {
  const core::Pose T_lidar_map = spin.T_odom_lidar.poses().front().T.inverse();
  FillOctree<Field>(
      region,
      [&](const core::Vec3& center) {
        const auto old = map->At(center);
        const auto seen = SightOf(T_lidar_map * center, spin, lidar, shape, params);
        return seen ? Updated(old, *seen, map->resolution_m(), params) : old;
      },
      map);
}

}  // namespace atlas::tests
