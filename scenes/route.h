// The way along which a sensor is carried through a scene: a YAML file (docs/recording.md).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/sensor_events.h"

namespace atlas::scenes {

/// How the carrier sways, so that a revolution is distorted by motion: amplitudes about the smooth path.
struct RouteSway {
  double roll_deg = 0.0, pitch_deg = 0.0, yaw_deg = 0.0;
  double bob_m = 0.0;    ///< up and down
  double step_hz = 1.6;  ///< of the steps
  // Of a carrier that is simulated (sim/locomotion/carried.cc), not of recorded data sets.
  double glance_deg = 0.0;   ///< now and then it turns this far aside and back; 0: never
  double turn_deg_s = 90.0;  ///< and turns no faster than this
};

struct Waypoint {
  core::Vec3 p_map = core::Vec3::Zero();
  std::optional<double> yaw_rad;  ///< heading there; without, the direction of the path
};

struct Route {
  std::filesystem::path file;
  bool above_ground = false;  ///< z of waypoints counts from the surface below them, not from the map's zero
  double speed_m_s = 1.0;
  int scans = 100;  ///< spread evenly over the way where no rate is asked for
  RouteSway sway;
  std::vector<Waypoint> waypoints;
};

/// @throws InputError "FILE:LINE: key: ..." for a missing file, an unknown key, fewer than two waypoints or
/// two at one place, a speed out of (0, 30] m/s.
Route LoadRoute(const std::filesystem::path& file);

/// The route that ships with a built-in scene. @throws InputError where it has none.
std::filesystem::path DefaultRouteOf(const std::string& scene);

/// Height of the surface below (x, y) next under `z`, or nothing.
using GroundBelow = std::function<std::optional<double>(double x, double y, double z)>;

/// The smooth curve through a route's waypoints, by arc length. Frame: map.
class RouteCurve {
 public:
  /// @throws InputError for a waypoint with no ground below where heights count from there.
  RouteCurve(const Route& route, const GroundBelow& ground);

  double length_m() const { return s_.back(); }
  core::Vec3 At(double along_m) const;
  /// Heading of the curve, turned at waypoints that give one; continuous, not wrapped.
  double YawAt(double along_m) const;

 private:
  void MeasureLength();
  void RaiseFromGround(const Route& route, const GroundBelow& ground);
  void FindHeadings(const Route& route, const std::vector<size_t>& waypoint_index);
  /// The index and share of the sample at arc length `along_m`.
  std::pair<size_t, double> Locate(double along_m) const;

  std::vector<core::Vec3> p_;
  std::vector<double> s_, yaw_;
};

/// T_map_lidar every `step_s` from time 0 to the route's end: a smooth curve through the waypoints at
/// constant speed, heading along it, swaying. @throws InputError for a waypoint with no ground below where
/// heights count from there.
core::PoseTrajectory DriveRoute(const Route& route, double speed_m_s, double step_s,
                                const GroundBelow& ground);

}  // namespace atlas::scenes
