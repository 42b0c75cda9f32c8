// Scalar reference of the cone integrator, stages 1 and 2: from a revolution to a range image over the beam
// grid, and the plane of the surface through each return. Plain doubles, a ray and a cell at a time.
//
//    azimuth -->            u: columns by ascending azimuth, v: rows from the highest beam down
//      . | . | .            each cell of the grid is matched to the undistorted ray nearest to its middle
//     ---+-*-+---           (thesis 4.5.3, Fig. 4.7); * is that ray, (du, dv) its place against the middle
//      . | . | .
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/lidar_model.h"
#include "core/sensor_events.h"
#include "mapping/integrator/integrator.h"

namespace atlas::tests::cone {

using core::Vec3;

/// The ideal grid of a spinning LiDAR.
struct Beams {
  int rows = 0, columns = 0;
  double column_pitch = 0.0, phase = 0.0, min_pitch = 0.0, mean_row_pitch = 0.0;  ///< radians
  bool clockwise = false;
  std::vector<double> elevation, row_pitch;  ///< a row each, from the highest down

  /// Column of an azimuth, in [0, columns).
  double ColumnOf(double azimuth) const {
    const double u = std::fmod((azimuth - phase) / column_pitch, columns);
    return u < 0.0 ? u + columns : u;
  }
  /// Row of an elevation: linear between beams, and on by the last pitch outside.
  double RowOf(double at) const {
    size_t below = 1;
    while (below + 1 < elevation.size() && elevation[below] > at) ++below;
    const double upper = elevation[below - 1], lower = elevation[below];
    return static_cast<double>(below - 1) + (upper - at) / (upper - lower);
  }
  int Wrap(int column) const { return ((column % columns) + columns) % columns; }
  size_t Cell(int row, int column) const { return static_cast<size_t>(row * columns + Wrap(column)); }
  /// Angles across a cell of a row.
  double ColumnAngle(int row) const { return column_pitch * std::cos(elevation[static_cast<size_t>(row)]); }
  double RowAngle(int row) const { return row_pitch[static_cast<size_t>(row)]; }
};

inline Beams BeamsOf(const core::LidarModel& lidar) {
  Beams b;
  b.rows = lidar.rows();
  b.columns = static_cast<int>(std::lround(2.0 * core::kPi / std::abs(lidar.StepRad())));
  b.column_pitch = b.min_pitch = 2.0 * core::kPi / b.columns;
  b.clockwise = lidar.StepRad() < 0.0;
  const double turn = (lidar.first_azimuth_rad + core::kPi) / b.column_pitch;
  b.phase = -core::kPi + (turn - std::floor(turn)) * b.column_pitch;
  b.elevation = lidar.elevation_rad;
  std::sort(b.elevation.begin(), b.elevation.end(), std::greater<>());
  for (size_t row = 0; row < b.elevation.size(); ++row) {
    const size_t above = row == 0 ? 0 : row - 1, below = std::min(row + 1, b.elevation.size() - 1);
    b.row_pitch.push_back((b.elevation[above] - b.elevation[below]) / static_cast<double>(below - above));
    if (row > 0) b.min_pitch = std::min(b.min_pitch, b.elevation[row - 1] - b.elevation[row]);
  }
  b.mean_row_pitch = (b.elevation.front() - b.elevation.back()) / (b.rows - 1);
  return b;
}

/// An undistorted ray: range > 0 is a return at `end`; < 0 nothing met up to -range; 0 no information.
struct Ray {
  bool pointed = false;
  double u = 0.0, v = 0.0, range = 0.0;
  Vec3 end = Vec3::Zero();  ///< the return, else the unit direction; LiDAR frame at the middle of the scan
};

/// The LiDAR's pose at the middle of the scan.
inline core::Pose MiddlePose(const core::SpinEvent& spin) {
  const auto [first, last] = std::minmax_element(spin.scan.time_s.begin(), spin.scan.time_s.end());
  return spin.T_odom_lidar.At(spin.scan.stamp_s +
                              0.5 * (static_cast<double>(*first) + static_cast<double>(*last)));
}

/// From the LiDAR at the time of a column to the LiDAR at the middle of the scan: asked for at every fourth
/// column, and interpolated entry by entry between. @pre rows share their times.
inline Eigen::Matrix4d PoseOfColumn(const core::SpinEvent& spin, size_t column) {
  const core::LidarScan& scan = spin.scan;
  const size_t before = column / 4 * 4, after = std::min(before + 4, static_cast<size_t>(scan.columns) - 1);
  const auto time = [&](size_t c) { return scan.stamp_s + static_cast<double>(scan.time_s[c]); };
  const auto pose = [&](size_t c) -> Eigen::Matrix4d {
    return (MiddlePose(spin).inverse() * spin.T_odom_lidar.At(time(c))).matrix();
  };
  if (before == after) return pose(before);
  const double w = (time(column) - time(before)) / (time(after) - time(before));
  return pose(before) + w * (pose(after) - pose(before));
}

/// Rays by rows of the scan, each by ascending azimuth.
inline std::vector<Ray> Project(const core::SpinEvent& spin, const Beams& beams,
                                const mapping::IntegratorParams& params) {
  const core::LidarScan& scan = spin.scan;
  std::vector<core::Pose> T_mid_lidar(static_cast<size_t>(scan.columns), core::Pose::Identity());
  for (size_t column = 0; params.motion_aware && column < T_mid_lidar.size(); ++column) {
    T_mid_lidar[column].matrix() = PoseOfColumn(spin, column);
  }
  const double trusted =
      params.void_rays == "ignore" ? 0.0 : std::min(params.void_range_m, params.max_range_m);
  std::vector<Ray> rays(scan.size());
  for (size_t i = 0; i < scan.size(); ++i) {
    const size_t column = i % static_cast<size_t>(scan.columns);
    const size_t to = beams.clockwise ? i - column + static_cast<size_t>(scan.columns) - 1 - column : i;
    const core::Pose& T = T_mid_lidar[column];
    const Vec3 direction = scan.direction_lidar[i].cast<double>();
    const bool hit = scan.kind[i] == core::ReturnKind::kHit;
    const Vec3 end =
        hit ? Vec3(T * (static_cast<double>(scan.range_m[i]) * direction)) : T.linear() * direction;
    const double length = end.norm();
    if (!(length > 1e-3 && length < 1e6)) continue;
    const bool within = hit && length <= params.max_range_m;
    Ray& ray = rays[to];
    ray.pointed = true;
    ray.u = beams.ColumnOf(std::atan2(end.y(), end.x()));
    ray.v = beams.RowOf(std::asin(end.z() / length));
    ray.end = within ? end : end / length;
    if (within) {
      ray.range = length;
    } else if (scan.kind[i] != core::ReturnKind::kDropout) {
      ray.range = hit ? -params.max_range_m : -trusted;
    }
  }
  return rays;
}

/// A cell of the range image and its matched ray.
struct Cell {
  int ray = -1;
  double du = 0.0, dv = 0.0;  ///< of the ray against the cell's middle, in cells
  double range = 0.0;         ///< as Ray
  Vec3 end = Vec3::Zero();
  // Stage 2, where range > 0: the plane of the surface.
  Vec3 normal = Vec3::Zero();  ///< unit, towards the sensor
  double inverse_cos = 0.0;    ///< of the incidence
  double free_range = 0.0;     ///< the nearer of the return and of its plane in the cell's own direction
};

struct RangeImage {
  Beams beams;
  std::vector<Cell> cells;
  std::vector<std::pair<size_t, Ray>>
      spare;           ///< returns that no cell took, with the cell that they fall into
  double reach = 0.0;  ///< of the farthest cell

  const Cell& At(int row, int column) const { return cells[beams.Cell(row, column)]; }
  double RangeAt(int row, int column) const {
    return row < 0 || row >= beams.rows ? 0.0 : At(row, column).range;
  }
};

/// A ray in the cell that it falls into, the one nearest to the middle of it.
struct Bin {
  int ray = -1;
  double du = 0.0, dv = 0.0;
};

inline double SquaredAngle(const Beams& beams, int row, double du, double dv) {
  return std::pow(du * beams.ColumnAngle(row), 2) + std::pow(dv * beams.RowAngle(row), 2);
}

inline std::vector<Bin> BinsOf(const std::vector<Ray>& rays, const Beams& beams) {
  std::vector<Bin> bins(static_cast<size_t>(beams.rows * beams.columns));
  for (size_t i = 0; i < rays.size(); ++i) {
    const int row = static_cast<int>(std::floor(rays[i].v + 0.5)),
              column = static_cast<int>(std::floor(rays[i].u + 0.5));
    if (!rays[i].pointed || row < 0 || row >= beams.rows) continue;
    Bin& bin = bins[beams.Cell(row, column)];
    const double du = rays[i].u - column, dv = rays[i].v - row;
    if (bin.ray < 0 || SquaredAngle(beams, row, du, dv) < SquaredAngle(beams, row, bin.du, bin.dv)) {
      bin = {static_cast<int>(i), du, dv};
    }
  }
  return bins;
}

/// The nearest of the rays in the 3 x 3 bins around a cell, within 0.75 cells along either axis. Bins beside
/// and above are looked at only while the cell's own ray is farther off than the stop angle and half a cell.
inline Bin MatchOf(const std::vector<Bin>& bins, const Beams& beams, int row, int column, double stop_rad) {
  constexpr double kFarthest = 0.75;
  Bin best;
  double least = 1e9;
  const auto offer = [&](int down, int right) {
    if (row + down < 0 || row + down >= beams.rows) return;
    Bin bin = bins[beams.Cell(row + down, column + right)];
    bin.du += right;
    bin.dv += down;
    const double e = SquaredAngle(beams, row, bin.du, bin.dv);
    if (bin.ray < 0 || std::abs(bin.du) > kFarthest || std::abs(bin.dv) > kFarthest || e >= least) return;
    best = bin;
    least = e;
  };
  offer(0, 0);
  const double own = std::sqrt(least);
  if (own > std::max(stop_rad, 0.5 * beams.ColumnAngle(row))) {
    offer(0, -1);
    offer(0, 1);
  }
  if (own > std::max(stop_rad, 0.5 * beams.RowAngle(row))) {
    for (const int down : {-1, 1}) {
      for (const int right : {-1, 0, 1}) offer(down, right);
    }
  }
  return best;
}

inline RangeImage Remap(const std::vector<Ray>& rays, const Beams& beams, double stop_rad) {
  RangeImage image;
  image.beams = beams;
  image.cells.resize(static_cast<size_t>(beams.rows * beams.columns));
  const std::vector<Bin> bins = BinsOf(rays, beams);
  std::vector<bool> taken(rays.size());
  for (int row = 0; row < beams.rows; ++row) {
    for (int column = 0; column < beams.columns; ++column) {
      const Bin match = MatchOf(bins, beams, row, column, stop_rad);
      if (match.ray < 0) continue;
      const Ray& ray = rays[static_cast<size_t>(match.ray)];
      taken[static_cast<size_t>(match.ray)] = true;
      Cell& cell = image.cells[beams.Cell(row, column)];
      cell.ray = match.ray;
      cell.du = match.du;
      cell.dv = match.dv;
      cell.range = ray.range;
      cell.end = ray.end;
      image.reach = std::max(image.reach, std::abs(ray.range));
    }
  }
  for (size_t i = 0; i < rays.size(); ++i) {
    if (taken[i] || rays[i].range <= 0.0) continue;
    const int row = std::clamp(static_cast<int>(std::floor(rays[i].v + 0.5)), 0, beams.rows - 1);
    image.spare.emplace_back(beams.Cell(row, static_cast<int>(std::floor(rays[i].u + 0.5))), rays[i]);
  }
  return image;
}

// --- Stage 2: planes. On a plane 1 / range is linear in the angle, so slopes are taken from inverse ranges:
// s = d(range) / d(angle) / range = (1 - range / neighbour) / angle.

struct Side {
  bool hit = false;
  double slope = 0.0;
};

inline Side SideOf(double range, double neighbour, double angle) {
  if (neighbour <= 0.0) return {};
  return {true, (1.0 - range / neighbour) / angle};
}

/// The mean where both sides continue one plane, else the flatter; none at a thin thing or across a gap.
inline double Joined(const Side& a, const Side& b, double range, double angle) {
  if (!a.hit || !b.hit) return a.hit ? a.slope : b.slope;
  const double allowed = 0.25 * (std::abs(a.slope) + std::abs(b.slope)) + 0.06 / range / angle;
  if (std::abs(a.slope - b.slope) <= allowed) return 0.5 * (a.slope + b.slope);
  const bool apart = a.slope * b.slope < 0.0 && std::abs(a.slope) > 4.0 && std::abs(b.slope) > 4.0;
  return apart ? 0.0 : std::abs(a.slope) < std::abs(b.slope) ? a.slope : b.slope;
}

/// Neighbours lie 10 cm off, a power of two of cells.
inline int StepFor(double range, double angle, int widest) {
  const double cells = std::clamp(0.10 / range / angle, 1.0, static_cast<double>(widest));
  return 1 << static_cast<int>(std::floor(std::log2(cells)));
}

inline void FindPlane(int row, int column, RangeImage* image) {
  const Beams& beams = image->beams;
  Cell& cell = image->cells[beams.Cell(row, column)];
  const double range = cell.range;
  const int right = StepFor(range, beams.ColumnAngle(row), 8), down = StepFor(range, beams.RowAngle(row), 4);
  const double across = right * beams.ColumnAngle(row);
  const auto angle_to = [&](int other) {
    const auto at = static_cast<size_t>(std::clamp(other, 0, beams.rows - 1));
    return std::max(1e-3, std::abs(beams.elevation[static_cast<size_t>(row)] - beams.elevation[at]));
  };
  const double above = angle_to(row - down), below = angle_to(row + down);
  const double azimuth = Joined(SideOf(range, image->RangeAt(row, column + right), across),
                                SideOf(range, image->RangeAt(row, column - right), -across), range, across);
  const double elevation =
      Joined(SideOf(range, image->RangeAt(row - down, column), above),
             SideOf(range, image->RangeAt(row + down, column), -below), range, 0.5 * (above + below));
  const Vec3 r = cell.end / range;
  const double flat = std::max(std::hypot(r.x(), r.y()), 1e-4);
  const Vec3 e_azimuth(-r.y() / flat, r.x() / flat, 0.0);
  const Vec3 e_elevation(-r.z() * r.x() / flat, -r.z() * r.y() / flat, flat);
  const double t = std::sqrt(1.0 + azimuth * azimuth + elevation * elevation);
  cell.normal = -(r - azimuth * e_azimuth - elevation * e_elevation) / t;
  cell.inverse_cos = std::min(t, 60.0);
  const double grows = azimuth * cell.du * beams.ColumnAngle(row) - elevation * cell.dv * beams.RowAngle(row);
  cell.free_range = range / (1.0 + std::clamp(grows, 0.0, 1.0));
}

inline void FindPlanes(RangeImage* image) {
  for (int row = 0; row < image->beams.rows; ++row) {
    for (int column = 0; column < image->beams.columns; ++column) {
      if (image->At(row, column).range > 0.0) FindPlane(row, column, image);
    }
  }
}

}  // namespace atlas::tests::cone
