#include "experiments/bench/motion_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "core/files.h"
#include "experiments/judge/point_grid.h"
#include "experiments/judge/scene_surface.h"
#include "experiments/report/text_table.h"
#include "experiments/results/statistics.h"
#include "mapping/integrator/integrator.h"
#include "mapping/meshing/marching_cubes.h"
#include "scenes/catalog.h"
#include "sim/sensors/lidar.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;

constexpr double kSensorHeight_m = 0.75;
constexpr double kPoseRate_hz = 400.0;
constexpr double kSliceHeight_m = 1.0;  ///< above the ground under the sensor
constexpr double kTruthSpacing_m = 0.02;
constexpr float kSearch_m = 0.5f;

/// The base's attitude over time, standing at one place.
using Attitude = std::function<core::Mat3(double time_s)>;

std::vector<core::SpinEvent> SpinInPlace(const scenes::SceneSpec& scene, const core::LidarModel& model,
                                         const Attitude& attitude, double duration_s, int threads) {
  sim::Raycaster raycaster(scene);
  sim::Lidar lidar(model, core::Rng(1).Split("lidar"));
  const Vec3 p = scene.T_map_spawn.translation() + Vec3(0.0, 0.0, kSensorHeight_m);
  const double period = 1.0 / model.spin_rate_hz;
  std::vector<core::SpinEvent> spins;
  for (double stamp = 0.0; stamp + period <= duration_s + 1e-9; stamp += period) {
    core::SpinEvent spin;
    const int samples = static_cast<int>(std::lround(period * kPoseRate_hz));
    for (int i = 0; i <= samples; ++i) {
      const double t = stamp + period * i / samples;
      spin.T_odom_lidar.Add(t, core::MakePose(scene.T_map_spawn.linear() * attitude(t), p));
    }
    spin.scan = lidar.Spin(
        &raycaster, stamp, spin.T_odom_lidar, [](double) {}, threads);
    spins.push_back(std::move(spin));
  }
  return spins;
}

core::TriMesh MapOf(const std::vector<core::SpinEvent>& spins, const core::LidarModel& model,
                    const core::Box3& region, double resolution_m, bool motion_aware, int threads) {
  mapping::IntegratorParams params;
  params.max_range_m = 20.0;
  params.motion_aware = motion_aware;
  params.region_map = region;
  params.threads = threads;
  mapping::OccupancyOctree map(resolution_m);
  const auto integrator = mapping::MakeConeIntegrator<mapping::OccupancyField>(params, model);
  for (const core::SpinEvent& spin : spins) integrator->Integrate(spin, core::Pose::Identity(), &map);
  return mapping::ExtractMesh(map, {.min_component_m2 = 0.0, .threads = threads});
}

std::vector<Vec3f> Slice(const std::vector<Vec3f>& points, double z, double thickness_m) {
  std::vector<Vec3f> slice;
  for (const Vec3f& p : points) {
    if (std::abs(static_cast<double>(p.z()) - z) < 0.5 * thickness_m) slice.push_back(p);
  }
  return slice;
}

MotionError ErrorOf(const core::TriMesh& mesh, const std::vector<Vec3f>& truth, const PointGrid& truth_grid,
                    const std::vector<uint8_t>& in_view, double resolution_m) {
  MotionError error;
  std::vector<double> distances;
  for (const Vec3f& vertex : mesh.vertices) {
    float distance = kSearch_m;
    truth_grid.Nearest(vertex, kSearch_m, &distance);
    distances.push_back(distance);
  }
  if (distances.empty()) return error;
  const auto count = static_cast<double>(distances.size());
  error.mean_m = std::accumulate(distances.begin(), distances.end(), 0.0) / count;
  error.p95_m = Percentile(distances, 0.95);
  error.beyond_voxel = static_cast<double>(std::count_if(distances.begin(), distances.end(),
                                                         [&](double d) { return d > resolution_m; })) /
                       count;
  const PointGrid vertices(mesh.vertices, resolution_m);
  size_t seen = 0, met = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (!in_view[i]) continue;
    float distance = 0.0f;
    ++seen;
    met += vertices.Nearest(truth[i], static_cast<float>(resolution_m), &distance) >= 0;
  }
  error.completeness = seen == 0 ? 0.0 : static_cast<double>(met) / static_cast<double>(seen);
  return error;
}

/// Truth that some undistorted return lies beside.
std::vector<uint8_t> InView(const std::vector<Vec3f>& truth, const PointGrid& grid,
                            const std::vector<core::SpinEvent>& spins, double radius_m) {
  std::vector<uint8_t> in_view(truth.size(), 0);
  for (const core::SpinEvent& spin : spins) {
    for (size_t i = 0; i < spin.scan.size(); ++i) {
      if (spin.scan.kind[i] != core::ReturnKind::kHit) continue;
      const core::Pose T = spin.T_odom_lidar.At(spin.scan.stamp_s + static_cast<double>(spin.scan.time_s[i]));
      const Vec3 p = T * (spin.scan.range_m[i] * spin.scan.direction_lidar[i]).cast<double>();
      float distance = 0.0f;
      const int64_t nearest = grid.Nearest(p.cast<float>(), static_cast<float>(radius_m), &distance);
      if (nearest >= 0) in_view[static_cast<size_t>(nearest)] = 1;
    }
  }
  return in_view;
}

MotionCase RunCase(MotionCase setting, const core::Box3& region, const Attitude& attitude, double duration_s,
                   int threads) {
  const scenes::SceneSpec scene = scenes::LoadScene(setting.scene);
  const core::LidarModel model = core::FindLidarModel(setting.lidar);
  const std::vector<core::SpinEvent> spins = SpinInPlace(scene, model, attitude, duration_s, threads);

  scenes::SceneSpec surfaces = scene;  // all of it, object or not
  for (scenes::ScenePart& part : surfaces.parts) part.is_object = false;
  const std::vector<Vec3f> truth = SampleBackground(surfaces, region.Inflated(0.3), kTruthSpacing_m);
  const PointGrid grid(truth, 0.1);
  const std::vector<uint8_t> in_view = InView(truth, grid, spins, setting.resolution_m);
  const double z = scene.T_map_spawn.translation().z() + kSliceHeight_m;
  setting.truth_slice = Slice(truth, z, kTruthSpacing_m);
  for (const bool aware : {false, true}) {
    const core::TriMesh mesh = MapOf(spins, model, region, setting.resolution_m, aware, threads);
    MotionError& error = aware ? setting.on : setting.off;
    error = ErrorOf(mesh, truth, grid, in_view, setting.resolution_m);
    error.motion_aware = aware;
    error.slice = Slice(mesh.vertices, z, setting.resolution_m);
  }
  return setting;
}

}  // namespace

std::vector<MotionCase> RunMotionBench(int threads) {
  const Attitude roll = [](double t) {
    return core::RotationFromYawPitchRoll(0.0, 0.0,
                                          core::Radians(40.0) * std::sin(2.0 * core::kPi * t / 6.0));
  };
  const Attitude turn = [](double t) {
    return core::RotationFromYawPitchRoll(core::Radians(180.0) * t, 0.0, 0.0);
  };
  const scenes::SceneSpec helicopter = scenes::LoadScene("helicopter"),
                          rooms = scenes::LoadScene("rooms_small");
  const Vec3 p = rooms.T_map_spawn.translation();
  const core::Box3 room{p - Vec3(6.0, 6.0, 0.3), p + Vec3(6.0, 6.0, 3.0)};
  return {RunCase({"sweep", "helicopter", "vlp16", "roll +-40 degrees in 6 s"}, helicopter.object_box, roll,
                  6.0, threads),
          RunCase({"turn", "rooms_small", "os1_64", "180 degrees a second"}, room, turn, 2.0, threads)};
}

}  // namespace atlas::experiments
