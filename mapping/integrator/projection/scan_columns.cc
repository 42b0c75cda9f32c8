// Which columns of a scan see what is kept.
#include <algorithm>
#include <cmath>

#include "mapping/integrator/projection/grid_columns.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

constexpr size_t kGroupColumns = 16;  ///< runs are whole groups
/// Beside the outermost column: windows of minima are up to 64 columns wide, planes look 8 columns aside.
constexpr double kMarginColumns = GridColumns::kWindowReach + kGroupColumns;
constexpr double kWidest = 0.9 * core::kPi;  ///< radians: boxes that span more may surround the sensor

/// Azimuths [from, to] that a box spans, `to` - `from` < pi; nullopt where it may surround the LiDAR's axis.
std::optional<std::pair<double, double>> AzimuthsOf(const core::Box3& box_map,
                                                    const core::Pose& T_map_lidar) {
  const core::Pose T_lidar_map = T_map_lidar.inverse();
  const Vec3 middle = T_lidar_map * (0.5 * (box_map.min + box_map.max));
  const double towards = std::atan2(middle.y(), middle.x());
  double from = 0.0, to = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? box_map.max[a] : box_map.min[a];
    p = T_lidar_map * p;
    const double azimuth = std::remainder(std::atan2(p.y(), p.x()) - towards, 2.0 * core::kPi);
    from = std::min(from, azimuth);
    to = std::max(to, azimuth);
  }
  // Within less than half a turn all corners lie on one side of the axis, and so does all between them.
  if (to - from > kWidest) return std::nullopt;
  return std::pair(towards + from, towards + to);
}

}  // namespace

void KeepColumns(const std::optional<core::Box3>& box_map, const core::Pose& T_map_lidar,
                 GridColumns* image) {
  const auto columns = static_cast<size_t>(image->columns);
  image->runs.assign(1, {0, columns});
  if (!box_map || columns % kGroupColumns != 0) return;
  const auto azimuths = AzimuthsOf(*box_map, T_map_lidar);
  if (!azimuths) return;
  const BeamGrid& grid = *image->grid;
  const auto group_of = [&](double azimuth, double margin) {
    const double column = (azimuth - grid.phase_rad) / grid.column_pitch_rad + margin;
    return static_cast<int64_t>(std::floor(column / static_cast<double>(kGroupColumns)));
  };
  const auto groups = static_cast<int64_t>(columns / kGroupColumns);
  const int64_t first = group_of(azimuths->first, -kMarginColumns);
  const int64_t count = group_of(azimuths->second, kMarginColumns) + 1 - first;
  if (count >= groups) return;
  const auto begin = static_cast<size_t>((first % groups + groups) % groups);
  const size_t end = begin + static_cast<size_t>(count);
  const auto total = static_cast<size_t>(groups);
  image->runs.assign(1, {kGroupColumns * begin, kGroupColumns * std::min(end, total)});
  if (end > total) image->runs.insert(image->runs.begin(), {0, kGroupColumns * (end - total)});
}

}  // namespace atlas::mapping
