// What the scanning action sees: where a LiDAR's rays go while the base rolls.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "core/roll_profile.h"

namespace atlas::planner {

/// How a sweep sees from a base pose.
struct SweepSensorModel {
  core::LidarModel lidar;
  core::Pose T_base_lidar = core::Pose::Identity();
  double base_height_m = 0.44;                       ///< above ground
  core::RollProfile roll{core::Radians(40.0), 6.0};  ///< of the base about its x axis, as it will be
};

/// Sensor rays per steradian of a whole sweep, by direction in the levelled base frame (x the robot's nose, z
/// up).
///
/// The base rolls about its x axis as the sweep's profile says, which dwells where the roll is greatest; at
/// every roll the LiDAR covers the elevations between its lowest and highest beam, all azimuths, with the
/// density of its beams. So a roll of 40 degrees widens a VLP-16's view to 55 degrees abeam but 20 dead
/// ahead, and abeam most rays go 30 to 50 degrees up and down.
///
///              abeam (y)                The beam plane turns about the nose: directions
///          \    |    /   +roll          near x stay where they are, directions near y
///            \  |  /                    swing by the whole roll.
///     -------- (x) --------
///
/// Approximations, each small against the spacing of candidates: the LiDAR's own tilt in the base is taken
/// into account, its lever arm about the roll axis is not (at most 0.25 m x sin 40 degrees).
class SweepView {
 public:
  explicit SweepView(const SweepSensorModel& sensor);

  /// Rays per steradian towards azimuth `azimuth_rad` (from the nose, to the left) and `elevation_rad`; 0
  /// where the sweep does not see. Tabulated at 1 degree.
  double RaysPerSteradian(double azimuth_rad, double elevation_rad) const {
    return table_[Row(elevation_rad) * kAzimuthCells + Column(azimuth_rad)];
  }
  /// Whether any part of the roll brings a beam onto this direction, exactly.
  bool Sees(const core::Vec3& direction_base) const;

  /// Elevations that every heading sees at every azimuth (the part seen dead ahead).
  double common_elevation_min_rad() const { return common_min_rad_; }
  double common_elevation_max_rad() const { return common_max_rad_; }
  /// Elevations outside of which nothing is ever seen.
  double elevation_min_rad() const { return min_rad_; }
  double elevation_max_rad() const { return max_rad_; }

  /// Where rays start, above the ground point under the base (levelled, roll 0, lever arm along x and y left
  /// out so that all headings share it).
  double sensor_height_m() const { return sensor_height_m_; }

 private:
  static constexpr int kAzimuthCells = 360;
  static constexpr int kElevationCells = 180;
  static size_t Row(double elevation_rad) {
    const int row = static_cast<int>((elevation_rad + 0.5 * core::kPi) * (kElevationCells / core::kPi));
    return static_cast<size_t>(row < 0 ? 0 : row >= kElevationCells ? kElevationCells - 1 : row);
  }
  static size_t Column(double azimuth_rad) {
    double turns = azimuth_rad * (0.5 / core::kPi);
    turns -= std::floor(turns);
    const int column = static_cast<int>(turns * kAzimuthCells);
    return static_cast<size_t>(column >= kAzimuthCells ? 0 : column);
  }

  void FillTable(double rays_in_sweep);
  double DensityAt(const core::Vec3& direction_base) const;
  void FindExtents();

  core::Mat3 R_lidar_base_;
  double roll_rad_ = 0.0;
  double sensor_height_m_ = 0.0;
  std::vector<double> beam_rad_;          ///< ascending elevations
  std::vector<double> edge_sine_;         ///< sines of the elevations where one beam is no longer the nearest
  std::vector<core::Vec2> roll_cos_sin_;  ///< of the rolls at even times of the sweep
  std::vector<double> beam_share_;        ///< of the rays per radian of elevation, about each beam
  std::vector<double> table_;             ///< row-major, elevation by azimuth
  double common_min_rad_ = 0.0, common_max_rad_ = 0.0, min_rad_ = 0.0, max_rad_ = 0.0;
};

}  // namespace atlas::planner
