#include "scenes/route.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors.h"
#include "core/files.h"
#include "scenes/build/smooth_way.h"
#include "scenes/yaml_fields.h"

namespace atlas::scenes {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kCurveStep_m = 0.05;
constexpr double kHeadingReach_m =
    0.35;  ///< the heading is the direction over this much of the path, both ways
constexpr double kHeightReach_m = 0.6;  ///< heights above ground are averaged over as much

double InRange(const YamlFields& fields, const std::string& key, double otherwise, double min, double max) {
  const double value = fields.Number(key, otherwise);
  if (value < min || value > max) {
    fields.Fail(key, fmt::format("{:g} is out of range [{:g}, {:g}]", value, min, max));
  }
  return value;
}

RouteSway ReadSway(const YamlFields& fields) {
  fields.AllowOnly({"roll_deg", "pitch_deg", "yaw_deg", "bob_m", "step_hz", "glance_deg", "turn_deg_s"});
  RouteSway sway;
  sway.roll_deg = InRange(fields, "roll_deg", 0.0, 0.0, 45.0);
  sway.pitch_deg = InRange(fields, "pitch_deg", 0.0, 0.0, 45.0);
  sway.yaw_deg = InRange(fields, "yaw_deg", 0.0, 0.0, 45.0);
  sway.bob_m = InRange(fields, "bob_m", 0.0, 0.0, 0.5);
  sway.step_hz = InRange(fields, "step_hz", sway.step_hz, 0.01, 10.0);
  sway.glance_deg = InRange(fields, "glance_deg", 0.0, 0.0, 90.0);
  sway.turn_deg_s = InRange(fields, "turn_deg_s", sway.turn_deg_s, 10.0, 360.0);
  return sway;
}

std::vector<Waypoint> ReadWaypoints(const YamlFields& fields) {
  std::vector<Waypoint> waypoints;
  for (const YamlFields& entry : fields.Children("waypoints")) {
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

/// Two tones an axis whose ratio is not simple, so that no two steps are alike.
double Sway(double amplitude, double hz, double phase, double time_s) {
  const double turn = 2.0 * core::kPi * time_s;
  return amplitude * (0.75 * std::sin(hz * turn + phase) + 0.25 * std::sin(1.618 * hz * turn + 2.0 * phase));
}

}  // namespace

Route LoadRoute(const std::filesystem::path& file) {
  const YamlFields fields = YamlFields::FromFile(file);
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

std::pair<size_t, double> RouteCurve::Locate(double along_m) const {
  const auto after = std::upper_bound(s_.begin(), s_.end(), along_m);
  const size_t i = std::clamp<size_t>(static_cast<size_t>(after - s_.begin()), 1, s_.size() - 1) - 1;
  return {i, std::clamp((along_m - s_[i]) / (s_[i + 1] - s_[i]), 0.0, 1.0)};
}

Vec3 RouteCurve::At(double along_m) const {
  const auto [i, u] = Locate(along_m);
  return p_[i] + u * (p_[i + 1] - p_[i]);
}

double RouteCurve::YawAt(double along_m) const {
  const auto [i, u] = Locate(along_m);
  return yaw_[i] + u * (yaw_[i + 1] - yaw_[i]);
}

void RouteCurve::MeasureLength() {
  s_.assign(1, 0.0);
  for (size_t i = 1; i < p_.size(); ++i) {
    s_.push_back(s_.back() + std::max(1e-9, (p_[i] - p_[i - 1]).norm()));
  }
}

/// Heights over the ground become heights in the map, averaged so that a kerb is no jump of the sensor.
void RouteCurve::RaiseFromGround(const Route& route, const GroundBelow& ground) {
  constexpr double kHeadroom_m = 0.4;
  std::vector<double> z;
  double floor_z = 0.0;
  for (size_t i = 0; i < p_.size(); ++i) {
    const Vec3& p = p_[i];
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
    p_[i].z() = sum / static_cast<double>(2 * near + 1);
  }
}

/// Headings along the curve, turned at waypoints that give one; in between the turn fades linearly.
void RouteCurve::FindHeadings(const Route& route, const std::vector<size_t>& waypoint_index) {
  const size_t n = p_.size();
  const auto reach = static_cast<size_t>(kHeadingReach_m / kCurveStep_m);
  yaw_.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const Vec3 along = p_[std::min(i + reach, n - 1)] - p_[i > reach ? i - reach : 0];
    const double previous = i > 0 ? yaw_[i - 1] : 0.0;
    const bool upright = along.head<2>().norm() < 1e-6;
    const double yaw = upright ? previous : std::atan2(along.y(), along.x());
    yaw_[i] = i > 0 ? previous + core::WrapAngle(yaw - previous) : yaw;
  }
  std::vector<double> turn;
  for (size_t k = 0; k < route.waypoints.size(); ++k) {
    const auto& given = route.waypoints[k].yaw_rad;
    turn.push_back(given ? core::WrapAngle(*given - yaw_[waypoint_index[k]]) : 0.0);
  }
  for (size_t k = 0; k + 1 < turn.size(); ++k) {
    const size_t first = waypoint_index[k], last = waypoint_index[k + 1];
    for (size_t i = first; i < last; ++i) {
      const double u = static_cast<double>(i - first) / static_cast<double>(last - first);
      yaw_[i] += (1.0 - u) * turn[k] + u * turn[k + 1];
    }
  }
  yaw_[n - 1] += turn.back();
}

RouteCurve::RouteCurve(const Route& route, const GroundBelow& ground) {
  std::vector<Vec3> way;
  std::vector<size_t> waypoint_index = {0};
  for (const Waypoint& waypoint : route.waypoints) way.push_back(waypoint.p_map);
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const auto steps = static_cast<size_t>(std::ceil((way[i + 1] - way[i]).norm() / kCurveStep_m));
    waypoint_index.push_back(waypoint_index.back() + std::max<size_t>(1, steps));
  }
  p_ = SmoothWay(way, kCurveStep_m);
  if (route.above_ground) RaiseFromGround(route, ground);
  MeasureLength();
  FindHeadings(route, waypoint_index);
}

core::PoseTrajectory DriveRoute(const Route& route, double speed_m_s, double step_s,
                                const GroundBelow& ground) {
  const RouteCurve curve(route, ground);
  const RouteSway& sway = route.sway;
  core::PoseTrajectory trajectory;
  const auto steps = static_cast<size_t>(std::ceil(curve.length_m() / speed_m_s / step_s));
  for (size_t k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) * step_s, s = std::min(curve.length_m(), speed_m_s * t);
    Vec3 p = curve.At(s);
    p.z() += Sway(sway.bob_m, 2.0 * sway.step_hz, 0.3, t);
    const double yaw = curve.YawAt(s) + Sway(core::Radians(sway.yaw_deg), sway.step_hz, 1.1, t);
    const double pitch = Sway(core::Radians(sway.pitch_deg), 2.0 * sway.step_hz, 2.2, t);
    const double roll = Sway(core::Radians(sway.roll_deg), sway.step_hz, 0.0, t);
    trajectory.Add(t, core::MakePose(core::RotationFromYawPitchRoll(yaw, pitch, roll), p));
  }
  return trajectory;
}

}  // namespace atlas::scenes
