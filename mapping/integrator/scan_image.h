// One revolution as images over the beam grid, in the LiDAR frame at the middle of the scan.
//
// Stages, each filling its part: remap (thesis 4.5.3: each grid cell gets the undistorted ray nearest to it),
// planes (the surface through each hit), tables (window minima for the free-space tests).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "core/sensor_events.h"
#include "mapping/integrator/beam_grid.h"

namespace atlas::mapping {

/// What the images need to know of the integrator's parameters.
struct ImageOptions {
  float resolution_m = 0.05f;
  float max_range_m = 60.0f;
  float void_range_m = 20.0f;  ///< 0: void rays are no evidence
  float sigma_min_m = 0.015f;
  float lambda_sigma = 0.0005f;
  float remap_stop_rad = 0.001f;
  float reach_behind_m = 0.0f;  ///< voxels this far behind a return still matter to the fill stage
  int max_scale = 4;
  bool motion_aware = true;
  int threads = 1;
};

struct ScanImage {
  const BeamGrid* grid = nullptr;
  int rows = 0, columns = 0;
  /// The columns that the stages fill, [first, last) in whole groups of 16: all, or those that see what is
  /// kept (KeepColumns). What the others hold is left over from other scans and stages.
  struct Run {
    size_t first, last;
  };
  std::vector<Run> runs;
  bool Filled(size_t column) const {
    for (const Run& run : runs) {
      if (column >= run.first && column < run.last) return true;
    }
    return false;
  }
  float pierce_voxels = 0.5f;  ///< a beam that passes this near to a cell's middle pierces it

  // --- Rays, rows of the scan by ascending azimuth. ray_range > 0: hit at ray_x.. (a point); < 0: nothing
  // met up to -ray_range, ray_x.. a unit direction; 0: no information. ray_u < 0: no direction either. Like
  // the bins they are gone once cells have chosen: planes and tables take over their memory, so that a scan
  // touches less.
  std::vector<float> ray_x, ray_y, ray_z, ray_range, ray_u, ray_v;

  // --- Cells, row * columns + column. The matched ray and its true place against the cell's (columns, rows).
  std::vector<int32_t> cell_ray;  ///< -1: unmatched
  std::vector<int32_t> offset;    ///< columns in the low half, rows in the high, in 1 / kPerCell
  static constexpr float kPerCell = 32768.0f;
  std::vector<float> range;    ///< as ray_range
  std::vector<float> x, y, z;  ///< as ray_x
  float reach_m = 0.0f;        ///< of the farthest cell
  /// Hits that no cell took, since another ray is nearer to each direction around.
  struct SpareHit {
    int32_t cell;  ///< that the ray falls into
    float range, end[3];
  };
  std::vector<SpareHit> spare;

  // --- Surface at hits: unit normal towards the sensor (LiDAR frame) and, with reach_behind_m,
  // 1 / cos(incidence).
  std::vector<float> nx, ny, nz, inverse_cos;

  // --- Tables. A margin image holds for each cell the range up to which space is free for cells of that
  // scale, with `pad` columns repeated on the right; scale index 0, 1, 2 is 1, 2, 4 voxels.
  static constexpr int kPad = 64;
  static constexpr int kLevels = 7;
  int pitch = 0;                               ///< columns + kPad
  std::array<std::vector<float>, 3> own;       ///< rows * pitch
  std::array<std::vector<float>, 3> surround;  ///< least over the 2 x 2 cells from (row, column); from row -1
  /// Scale 1: least over window_rows x window_columns from (row, column); from row -(window_rows - 1).
  std::array<std::vector<float>, kLevels> window;
  std::array<int, kLevels> window_rows, window_columns;

  /// Box tables: packed bounds over 2^k rows x 2^(k + box_shift) columns from (row, column) of the grid: low
  /// half the least `own`, high half 65535 - the greatest bound, both in units of box_unit_m.
  static constexpr int kBoxLevels = 6;
  std::vector<uint32_t> box;  ///< [level][row][box_pitch]
  size_t box_pitch = 0, box_stride = 0;
  int box_shift = 0;
  float box_unit_m = 0.001f;

  // --- Kept from scan to scan, so that no stage asks for memory: the rays in the cells that they fall into,
  // with a column of margin on either side, which rays were taken, and a row of bounds.
  struct Bins {
    std::vector<float> du, dv;
    std::vector<int32_t> ray;
    size_t pitch = 0;
  };
  Bins bins;
  std::vector<uint8_t> taken;
  std::vector<float> row_bound;
  std::vector<float> row_reach_m;  ///< a worker each
};

/// Poses of the LiDAR through the revolution against its middle, a column each, as rows of 3 x 4 matrices.
struct ColumnPoses {
  core::Pose T_odom_mid;
  bool moving = false;
  std::array<std::vector<float>, 12> T_mid_lidar;  ///< a column each, where moving
  std::vector<int32_t> pose_of_ray;  ///< where the rays of a column do not share a time; else empty
};
void PosesOfScan(const core::SpinEvent& spin, bool motion_aware, ColumnPoses* poses);

/// Narrows the columns that are filled to those in which parts of the box may lie, and as many beside them as
/// windows reach; nullopt: all.
void KeepColumns(const std::optional<core::Box3>& box_map, const core::Pose& T_map_lidar, ScanImage* image);

/// Fills the bins: of the rays that fall into a cell, the one nearest to its middle.
void BinRays(ScanImage* image);
void RemapScan(const core::LidarScan& scan, const ColumnPoses& poses, const ImageOptions& options,
               ScanImage* image);
/// @param rotation_map_lidar  for the voxel's support along normals.
void FindPlanes(const core::Mat3& rotation_map_lidar, const ImageOptions& options, ScanImage* image);
void BuildTables(const ImageOptions& options, ScanImage* image);

/// Sizes the tables for the image's grid.
void PrepareTables(ScanImage* image);
/// Sizes everything for a grid, tables too.
void PrepareImage(const BeamGrid& grid, ScanImage* image);

}  // namespace atlas::mapping
