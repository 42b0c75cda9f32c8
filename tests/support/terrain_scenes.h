// A ray caster over analytic patches, and the events that a sensor on a robot would send from such a world.
// It is the oracle of the terrain tests: it shares nothing with the simulator or with the map.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "core/rng.h"
#include "core/sensor_events.h"

namespace atlas::tests {

/// A parallelogram corner + a u + b v (a, b in [0, 1]); a ray passes it with probability `transmission`.
struct Patch {
  core::Vec3 corner, u, v;
  double transmission = 0.0;
};

struct PatchWorld {
  std::vector<Patch> patches;

  void AddRectangle(double x0, double y0, double x1, double y1, double z, double transmission = 0.0) {
    patches.push_back({{x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}, transmission});
  }
  /// A level plate with a rectangular hole, as four rectangles about it.
  void AddPlateWithHole(double x0, double y0, double x1, double y1, double z, const core::Box3& hole,
                        double transmission = 0.0) {
    AddRectangle(x0, y0, hole.min.x(), y1, z, transmission);
    AddRectangle(hole.max.x(), y0, x1, y1, z, transmission);
    AddRectangle(hole.min.x(), y0, hole.max.x(), hole.min.y(), z, transmission);
    AddRectangle(hole.min.x(), hole.max.y(), hole.max.x(), y1, z, transmission);
  }
  void AddBox(const core::Vec3& min, const core::Vec3& max) {
    const core::Vec3 d = max - min;
    const core::Vec3 x(d.x(), 0, 0), y(0, d.y(), 0), z(0, 0, d.z());
    for (const core::Vec3& corner : {min, max}) {
      const double s = corner == min ? 1.0 : -1.0;
      patches.push_back({corner, s * x, s * y});
      patches.push_back({corner, s * y, s * z});
      patches.push_back({corner, s * z, s * x});
    }
  }

  /// Range of the first patch that stops the ray, or infinity. `draw` yields uniform numbers for partly
  /// transmissive patches.
  double Cast(const core::Vec3& origin, const core::Vec3& direction, core::Rng* draw) const {
    double skip = 0.0;
    while (true) {
      double nearest = std::numeric_limits<double>::infinity();
      const Patch* met = nullptr;
      for (const Patch& patch : patches) {
        const core::Vec3 n = patch.u.cross(patch.v);
        const double along = n.dot(direction);
        if (std::abs(along) < 1e-12) continue;
        const double t = n.dot(patch.corner - origin) / along;
        if (t <= skip || t >= nearest) continue;
        const core::Vec3 q = origin + t * direction - patch.corner;
        const double a = q.dot(patch.u) / patch.u.squaredNorm(), b = q.dot(patch.v) / patch.v.squaredNorm();
        if (a < 0.0 || a > 1.0 || b < 0.0 || b > 1.0) continue;  // u and v are at right angles
        nearest = t;
        met = &patch;
      }
      if (met == nullptr || met->transmission <= 0.0 || draw->Uniform() >= met->transmission) return nearest;
      skip = nearest + 1e-6;
    }
  }
};

/// Two floors, 3 m apart, and a ramp of 17.2 degrees beside the upper one that joins them:
///
///      y 2.5  +---------------------------+
///             |  upper floor    [hole]    |        on the lower floor, below the upper one: a post
///             |                  (post)   |
///       -2.0  +--------------------+      |
///    0 m -> ===== ramp, to the right =>  3 m       z = 0 all about
///       -3.6  ---------------------+------+
///      x -5   -2                  4.7    6.3
struct Storeys {
  static constexpr double kUpper_m = 3.0, kEdge_y = 2.5;
  inline static const core::Vec2 kHole{3.0, 1.5}, kPost{3.0, -0.8};

  PatchWorld world;

  Storeys() {
    world.AddRectangle(-14, -14, 14, 14, 0);
    core::Box3 hole;
    hole.min = core::Vec3(kHole.x() - 0.6, kHole.y() - 0.6, 0);
    hole.max = core::Vec3(kHole.x() + 0.6, kHole.y() + 0.6, 0);
    for (const double z : {kUpper_m, kUpper_m - 0.3}) {
      world.AddPlateWithHole(-2, -2, 6.3, kEdge_y, z, hole);
      world.AddRectangle(4.7, -3.6, 6.3, -2, z);
    }
    world.patches.push_back({{-5, -3.6, 0}, {9.7, 0, kUpper_m}, {0, 1.6, 0}});
    const core::Vec3 post(kPost.x(), kPost.y(), 0);
    world.AddBox(post - core::Vec3(0.2, 0.2, 0), post + core::Vec3(0.2, 0.2, 1.0));
  }
  /// The middle of the ramp, from its foot (0) to its top (1).
  static core::Vec3 OnRamp(double s) { return {-5 + 9.7 * s, -2.8, kUpper_m * s}; }
  static bool NearThings(const core::Vec2& p, double distance_m) {
    return std::min((p - kHole).norm(), (p - kPost).norm()) < distance_m;
  }
  /// Stands from the lower floor up the ramp to the same place on the upper one.
  static std::vector<core::Vec3> Climb() {
    std::vector<core::Vec3> stands = {{0.6, 0.3, 0}, {3.4, 0.4, 0}, {-3.5, 0, 0}, {-5.9, -2.8, 0}};
    for (const double s : {0.2, 0.4, 0.6, 0.8, 1.0}) stands.push_back(OnRamp(s));
    for (const core::Vec2& p : {core::Vec2(5.3, -0.6), core::Vec2(2.6, 0.2), core::Vec2(0.6, 0.3)}) {
      stands.emplace_back(p.x(), p.y(), kUpper_m);
    }
    return stands;
  }
};

/// Ideal sensors on a robot that stands in a PatchWorld, with the noise of the LiDAR and
/// localisation.
class TerrainSensors {
 public:
  TerrainSensors(const PatchWorld* world, uint64_t seed)
      : world_(*world), rng_(seed), model_(core::FindLidarModel("vlp16")) {}

  double range_sigma_m = 0.01;
  double lidar_above_base_m = 0.25;
  int column_stride = 1;  ///< every n-th firing only, for tests that need less

  /// One revolution while the base moves as `T_map_base_at(time)`. Odometry is the truth.
  core::SpinEvent Spin(double stamp_s, const std::function<core::Pose(double)>& T_map_base_at) {
    core::SpinEvent event;
    core::LidarScan& scan = event.scan;
    scan.stamp_s = stamp_s;
    scan.rows = model_.rows();
    scan.columns = model_.columns / column_stride;
    const size_t count = static_cast<size_t>(scan.rows) * static_cast<size_t>(scan.columns);
    scan.direction_lidar.resize(count);
    scan.range_m.assign(count, 0.0f);
    scan.time_s.resize(count);
    scan.kind.assign(count, core::ReturnKind::kVoid);
    const double period = 1.0 / model_.spin_rate_hz;
    for (int k = 0; k <= 10; ++k) {
      const double t = stamp_s + 0.1 * k * period;
      event.T_odom_lidar.Add(t, LidarPose(T_map_base_at(t)));
    }
    for (int c = 0; c < scan.columns; ++c) {
      const double t = period * c / scan.columns, azimuth = -2.0 * core::kPi * c / scan.columns;
      const core::Pose T = LidarPose(T_map_base_at(stamp_s + t));
      for (int r = 0; r < scan.rows; ++r) {
        const double e = model_.elevation_rad[static_cast<size_t>(r)];
        const core::Vec3 d(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e));
        const size_t i = static_cast<size_t>(r) * static_cast<size_t>(scan.columns) + static_cast<size_t>(c);
        scan.direction_lidar[i] = d.cast<float>();
        scan.time_s[i] = static_cast<float>(t);
        const double range = world_.Cast(T.translation(), T.linear() * d, &rng_);
        if (range > model_.max_range_m) continue;
        scan.kind[i] = core::ReturnKind::kHit;
        scan.range_m[i] = static_cast<float>(range + range_sigma_m * rng_.Normal());
      }
    }
    return event;
  }

  /// Standing upright at `T_map_base`, all feet down.
  core::StateEvent State(double time_s, const core::Pose& T_map_base, bool feet = true) {
    core::StateEvent state;
    state.time_s = time_s;
    state.T_odom_base = T_map_base;
    for (int foot = 0; foot < 4; ++foot) {
      const core::Vec3 p_base(foot < 2 ? 0.34 : -0.34, foot % 2 == 0 ? 0.235 : -0.235, -0.44);
      state.foot_odom[foot] = T_map_base * p_base;
      state.foot_in_contact[foot] = feet;
    }
    return state;
  }

  /// The scanning action: spins while the base rolls to +roll, to -roll and back, `spins` in all.
  void Sweep(const core::Pose& T_map_stand, double roll_rad, int spins, core::SensorSink* sink) {
    const double period = 1.0 / model_.spin_rate_hz, duration = spins * period;
    const auto pose_at = [&](double t) {
      const double roll = roll_rad * std::sin(2.0 * core::kPi * t / duration);
      return core::Pose(T_map_stand *
                        core::MakePose(core::RotationFromYawPitchRoll(0, 0, roll), core::Vec3::Zero()));
    };
    for (int k = 0; k < spins; ++k) {
      sink->OnState(State(k * period, T_map_stand));
      sink->OnSpin(std::make_shared<const core::SpinEvent>(Spin(k * period, pose_at)));
    }
  }

  /// A depth image from a camera `height_m` above the base, looking forward and down by `pitch_rad`; every
  /// `nan_stride`-th pixel is NaN (0: none).
  core::DepthEvent Depth(const core::Pose& T_map_base, double forward_m, double pitch_rad, int nan_stride) {
    core::DepthEvent event;
    core::DepthImage& image = event.image;
    image.width = 212;
    image.height = 120;
    image.focal_px = 106.0 / std::tan(core::Radians(43.0));
    core::Mat3 R_level;  // camera x right, y down, z forward; base x forward, y left, z up
    R_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    const core::Mat3 R = core::RotationFromYawPitchRoll(0, pitch_rad, 0) * R_level;
    event.T_odom_camera = T_map_base * core::MakePose(R, {forward_m, 0, 0});
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        const core::Vec3 ray((u + 0.5 - 106.0) / image.focal_px, (v + 0.5 - 60.0) / image.focal_px, 1.0);
        const double range = world_.Cast(event.T_odom_camera.translation(),
                                         event.T_odom_camera.linear() * ray.normalized(), &rng_);
        const double depth = range / ray.norm();
        const bool lost = nan_stride > 0 && (v * image.width + u) % nan_stride == 0;
        image.depth_m.push_back(depth <= 3.0 && !lost ? static_cast<float>(depth)
                                                      : std::numeric_limits<float>::quiet_NaN());
      }
    }
    return event;
  }

 private:
  core::Pose LidarPose(const core::Pose& T_map_base) const {
    return T_map_base * core::MakePose(core::Mat3::Identity(), {0, 0, lidar_above_base_m});
  }

  const PatchWorld& world_;
  core::Rng rng_;
  core::LidarModel model_;
};

}  // namespace atlas::tests
