#include "experiments/record/route.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors.h"
#include "core/files.h"
#include "scenes/build/smooth_way.h"
#include "scenes/yaml_fields.h"

namespace atlas::experiments {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kCurveStep_m = 0.05;
constexpr double kHeadingReach_m =
    0.35;  ///< the heading is the direction over this much of the path, both ways
constexpr double kHeightReach_m = 0.6;  ///< heights above ground are averaged over as much

double InRange(const scenes::YamlFields& fields, const std::string& key, double otherwise, double min,
               double max) {
  const double value = fields.Number(key, otherwise);
  if (value < min || value > max) {
    fields.Fail(key, fmt::format("{:g} is out of range [{:g}, {:g}]", value, min, max));
  }
  return value;
}

RouteSway ReadSway(const scenes::YamlFields& fields) {
  fields.AllowOnly({"roll_deg", "pitch_deg", "yaw_deg", "bob_m", "step_hz"});
  RouteSway sway;
  sway.roll_deg = InRange(fields, "roll_deg", 0.0, 0.0, 45.0);
  sway.pitch_deg = InRange(fields, "pitch_deg", 0.0, 0.0, 45.0);
  sway.yaw_deg = InRange(fields, "yaw_deg", 0.0, 0.0, 45.0);
  sway.bob_m = InRange(fields, "bob_m", 0.0, 0.0, 0.5);
  sway.step_hz = InRange(fields, "step_hz", sway.step_hz, 0.01, 10.0);
  return sway;
}

std::vector<Waypoint> ReadWaypoints(const scenes::YamlFields& fields) {
  std::vector<Waypoint> waypoints;
  for (const scenes::YamlFields& entry : fields.Children("waypoints")) {
    entry.AllowOnly({"at", "yaw_deg"});
    Waypoint waypoint;
    waypoint.p_map = entry.Numbers("at", 3);
    if (entry.Has("yaw_deg")) waypoint.yaw_rad = core::Radians(entry.Number("yaw_deg"));
    if (!waypoints.empty() && (waypoint.p_map - waypoints.back().p_map).norm() < 0.05) {
      entry.Fail("at", "less than 5 cm from the waypoint before");
    }
    waypoints.push_back(waypoint);
  }
  if (waypoints.size() < 2) fields.Fail("waypoints", "a route has at least two");
  return waypoints;
}

/// The curve by arc length.
struct Curve {
  std::vector<Vec3> p;
  std::vector<double> s;
  std::vector<double> yaw;  ///< unwrapped

  double length() const { return s.back(); }
  /// The index and share of the sample at arc length `at`.
  std::pair<size_t, double> Locate(double at) const {
    const auto after = std::upper_bound(s.begin(), s.end(), at);
    const size_t i = std::clamp<size_t>(static_cast<size_t>(after - s.begin()), 1, s.size() - 1) - 1;
    return {i, std::clamp((at - s[i]) / (s[i + 1] - s[i]), 0.0, 1.0)};
  }
  Vec3 At(double at) const {
    const auto [i, u] = Locate(at);
    return p[i] + u * (p[i + 1] - p[i]);
  }
  double YawAt(double at) const {
    const auto [i, u] = Locate(at);
    return yaw[i] + u * (yaw[i + 1] - yaw[i]);
  }
};

void MeasureLength(Curve* curve) {
  curve->s.assign(1, 0.0);
  for (size_t i = 1; i < curve->p.size(); ++i) {
    curve->s.push_back(curve->s.back() + std::max(1e-9, (curve->p[i] - curve->p[i - 1]).norm()));
  }
}

/// Heights over the ground become heights in the map, averaged so that a kerb is no jump of the sensor.
void RaiseFromGround(const Route& route, const GroundBelow& ground, Curve* curve) {
  constexpr double kHeadroom_m = 0.4;
  std::vector<double> z;
  double floor_z = 0.0;
  for (size_t i = 0; i < curve->p.size(); ++i) {
    const Vec3& p = curve->p[i];
    const double from = i == 0 ? p.z() + 2.0 : floor_z + std::max(p.z(), kHeadroom_m);
    const std::optional<double> below = ground(p.x(), p.y(), from);
    if (!below) {
      throw core::InputError(
          fmt::format("{}: waypoints: no ground under ({:.1f}, {:.1f})", route.file.string(), p.x(), p.y()));
    }
    floor_z = *below;
    z.push_back(floor_z + p.z());
  }
  const auto reach = static_cast<size_t>(kHeightReach_m / kCurveStep_m);
  for (size_t i = 0; i < z.size(); ++i) {
    const size_t near = std::min({reach, i, z.size() - 1 - i});
    double sum = 0.0;
    for (size_t k = i - near; k <= i + near; ++k) sum += z[k];
    curve->p[i].z() = sum / static_cast<double>(2 * near + 1);
  }
}

/// Headings along the curve, turned at waypoints that give one; in between the turn fades linearly.
void FindHeadings(const Route& route, const std::vector<size_t>& waypoint_index, Curve* curve) {
  const size_t n = curve->p.size();
  const auto reach = static_cast<size_t>(kHeadingReach_m / kCurveStep_m);
  curve->yaw.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const Vec3 along = curve->p[std::min(i + reach, n - 1)] - curve->p[i > reach ? i - reach : 0];
    const double previous = i > 0 ? curve->yaw[i - 1] : 0.0;
    const bool upright = along.head<2>().norm() < 1e-6;
    const double yaw = upright ? previous : std::atan2(along.y(), along.x());
    curve->yaw[i] = i > 0 ? previous + core::WrapAngle(yaw - previous) : yaw;
  }
  std::vector<double> turn;
  for (size_t k = 0; k < route.waypoints.size(); ++k) {
    const auto& given = route.waypoints[k].yaw_rad;
    turn.push_back(given ? core::WrapAngle(*given - curve->yaw[waypoint_index[k]]) : 0.0);
  }
  for (size_t k = 0; k + 1 < turn.size(); ++k) {
    const size_t first = waypoint_index[k], last = waypoint_index[k + 1];
    for (size_t i = first; i < last; ++i) {
      const double u = static_cast<double>(i - first) / static_cast<double>(last - first);
      curve->yaw[i] += (1.0 - u) * turn[k] + u * turn[k + 1];
    }
  }
  curve->yaw[n - 1] += turn.back();
}

Curve MakeCurve(const Route& route, const GroundBelow& ground) {
  std::vector<Vec3> way;
  std::vector<size_t> waypoint_index = {0};
  for (const Waypoint& waypoint : route.waypoints) way.push_back(waypoint.p_map);
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const auto steps = static_cast<size_t>(std::ceil((way[i + 1] - way[i]).norm() / kCurveStep_m));
    waypoint_index.push_back(waypoint_index.back() + std::max<size_t>(1, steps));
  }
  Curve curve;
  curve.p = scenes::SmoothWay(way, kCurveStep_m);
  if (route.above_ground) RaiseFromGround(route, ground, &curve);
  MeasureLength(&curve);
  FindHeadings(route, waypoint_index, &curve);
  return curve;
}

/// Two tones an axis whose ratio is not simple, so that no two steps are alike.
double Sway(double amplitude, double hz, double phase, double time_s) {
  const double turn = 2.0 * core::kPi * time_s;
  return amplitude * (0.75 * std::sin(hz * turn + phase) + 0.25 * std::sin(1.618 * hz * turn + 2.0 * phase));
}

}  // namespace

Route LoadRoute(const std::filesystem::path& file) {
  const scenes::YamlFields fields = scenes::YamlFields::FromFile(file);
  fields.AllowOnly({"heights", "speed_m_s", "scans", "sway", "waypoints"});
  Route route;
  route.file = file;
  const std::string heights = fields.Text("heights", "map");
  if (heights != "map" && heights != "above_ground") {
    fields.Fail("heights", core::UnknownName("reference of heights", heights, {"map", "above_ground"}));
  }
  route.above_ground = heights == "above_ground";
  route.speed_m_s = InRange(fields, "speed_m_s", 1.0, 0.01, 30.0);
  const double scans = InRange(fields, "scans", 100, 1, 100000);
  if (scans != std::floor(scans)) fields.Fail("scans", "not a whole number");
  route.scans = static_cast<int>(scans);
  if (fields.Has("sway")) route.sway = ReadSway(fields.Child("sway"));
  route.waypoints = ReadWaypoints(fields);
  return route;
}

std::filesystem::path DefaultRouteOf(const std::string& scene) {
  try {
    return core::InstalledFile("scenes/routes/" + scene + ".yaml");
  } catch (const core::InputError&) {
    throw core::InputError("scene " + scene + " has no route of its own; give one with --route FILE.yaml");
  }
}

core::PoseTrajectory DriveRoute(const Route& route, double speed_m_s, double step_s,
                                const GroundBelow& ground) {
  const Curve curve = MakeCurve(route, ground);
  const RouteSway& sway = route.sway;
  core::PoseTrajectory trajectory;
  const auto steps = static_cast<size_t>(std::ceil(curve.length() / speed_m_s / step_s));
  for (size_t k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) * step_s, s = std::min(curve.length(), speed_m_s * t);
    Vec3 p = curve.At(s);
    p.z() += Sway(sway.bob_m, 2.0 * sway.step_hz, 0.3, t);
    const double yaw = curve.YawAt(s) + Sway(core::Radians(sway.yaw_deg), sway.step_hz, 1.1, t);
    const double pitch = Sway(core::Radians(sway.pitch_deg), 2.0 * sway.step_hz, 2.2, t);
    const double roll = Sway(core::Radians(sway.roll_deg), sway.step_hz, 0.0, t);
    trajectory.Add(t, core::MakePose(core::RotationFromYawPitchRoll(yaw, pitch, roll), p));
  }
  return trajectory;
}

}  // namespace atlas::experiments
