#include "experiments/record/recorder.h"

#include <fmt/format.h>

#include <cmath>

#include "core/errors.h"
#include "core/rng.h"
#include "experiments/record/truth_seen.h"
#include "scenes/catalog.h"
#include "sim/sensors/lidar.h"
#include "sim/sensors/raycaster.h"

namespace atlas::experiments {
namespace {

using core::Vec3;

constexpr double kTrajectoryStep_s = 0.005;

core::LidarModel ModelFor(const RecordOptions& options) {
  core::LidarModel model = core::FindLidarModel(options.lidar);
  if (!options.noise) model.range_sigma_m = model.dropout_probability = 0.0;
  return model;
}

scenes::Route RouteFor(const RecordOptions& options) {
  return scenes::LoadRoute(options.route.empty() ? scenes::DefaultRouteOf(options.scene) : options.route);
}

void CheckInside(const scenes::Route& route, const scenes::SceneSpec& scene) {
  const core::Box3& box = scene.bounds;
  for (size_t i = 0; i < route.waypoints.size(); ++i) {
    const Vec3& p = route.waypoints[i].p_map;
    if (p.x() >= box.min.x() && p.x() <= box.max.x() && p.y() >= box.min.y() && p.y() <= box.max.y())
      continue;
    throw core::InputError(fmt::format(
        "{}: waypoints[{}].at: ({:.2f}, {:.2f}) lies outside the scene, which is x {:.1f} to {:.1f}, y "
        "{:.1f} to {:.1f}",
        route.file.string(), i, p.x(), p.y(), box.min.x(), box.max.x(), box.min.y(), box.max.y()));
  }
}

/// A ray from each pose to one some 10 cm on: a sensor does not pass through surfaces.
void CheckClear(const scenes::Route& route, const core::PoseTrajectory& trajectory,
                const sim::Raycaster& raycaster) {
  constexpr double kStride_m = 0.1;
  std::vector<core::Ray> rays;
  std::vector<float> length;
  Vec3 from = trajectory.poses().front().T.translation();
  for (const core::StampedPose& pose : trajectory.poses()) {
    const Vec3 to = pose.T.translation();
    if ((to - from).norm() < kStride_m) continue;
    rays.push_back({from.cast<float>(), (to - from).normalized().cast<float>()});
    length.push_back(static_cast<float>((to - from).norm()));
    from = to;
  }
  std::vector<sim::RayHit> hits(rays.size());
  raycaster.CastStatic(rays, 100.0f, 1, hits);
  for (size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].range_m < 0.0f || hits[i].range_m > length[i]) continue;
    const core::Vec3f p = rays[i].origin + hits[i].range_m * rays[i].direction;
    throw core::InputError(
        fmt::format("{}: waypoints: the way passes through a surface at ({:.2f}, {:.2f}, {:.2f})",
                    route.file.string(), p.x(), p.y(), p.z()));
  }
}

scenes::GroundBelow GroundOf(const sim::Raycaster& raycaster) {
  return [&raycaster](double x, double y, double z) -> std::optional<double> {
    const core::Ray down{Vec3(x, y, z).cast<float>(), -core::Vec3f::UnitZ()};
    sim::RayHit hit;
    raycaster.CastStatic({&down, 1}, 200.0f, 1, {&hit, 1});
    if (hit.range_m < 0.0f) return std::nullopt;
    return z - hit.range_m;
  };
}

double LengthOf(const core::PoseTrajectory& trajectory) {
  double length = 0.0;
  const auto& poses = trajectory.poses();
  for (size_t i = 1; i < poses.size(); ++i)
    length += (poses[i].T.translation() - poses[i - 1].T.translation()).norm();
  return length;
}

/// Starts of the revolutions, on whole nanoseconds, as file names carry them.
std::vector<double> StampsFor(const RecordOptions& options, const scenes::Route& route,
                              const core::LidarModel& model, double duration_s) {
  const double last_s = duration_s - 1.0 / model.spin_rate_hz;
  if (last_s < 0.0) {
    throw core::InputError(fmt::format("{}: the way takes {:.2f} s, less than a revolution of the {}",
                                       route.file.string(), duration_s, model.name));
  }
  if (options.rate_hz && !(*options.rate_hz > 0.0 && *options.rate_hz <= model.spin_rate_hz)) {
    throw core::InputError(
        fmt::format("record: --rate {:g}: from above 0 to the {:g} Hz at which the {} spins",
                    *options.rate_hz, model.spin_rate_hz, model.name));
  }
  int count = options.scans.value_or(route.scans);
  double step_s = count > 1 ? last_s / (count - 1) : 0.0;
  if (options.rate_hz) {
    step_s = 1.0 / *options.rate_hz;
    const auto fit = static_cast<int>(last_s / step_s + 1e-9) + 1;
    count = options.scans ? std::min(*options.scans, fit) : fit;
  }
  if (count > 1 && step_s * model.spin_rate_hz < 1.0 - 1e-9) {
    throw core::InputError(
        fmt::format("record: --scans {}: the way of {:.1f} s has time for {} revolutions of the {}", count,
                    duration_s, static_cast<int>(last_s * model.spin_rate_hz) + 1, model.name));
  }
  std::vector<double> stamps;
  for (int k = 0; k < count; ++k) stamps.push_back(std::floor(k * step_s * 1e9 + 0.5) * 1e-9);
  return stamps;
}

}  // namespace

struct DatasetRecorder::Impl {
  explicit Impl(const RecordOptions& given)
      : options(given),
        model(ModelFor(given)),
        scene(scenes::LoadScene(given.scene)),
        route(RouteFor(given)),
        raycaster(scene),
        lidar(model, core::Rng(given.seed)) {
    CheckInside(route, scene);
    raycaster.CommitPoses();
    trajectory = scenes::DriveRoute(route, options.speed_m_s.value_or(route.speed_m_s), kTrajectoryStep_s,
                                    GroundOf(raycaster));
    CheckClear(route, trajectory, raycaster);
    length_m = LengthOf(trajectory);
    stamps_s = StampsFor(options, route, model, trajectory.poses().back().time_s);
  }

  RecordOptions options;
  core::LidarModel model;
  scenes::SceneSpec scene;
  scenes::Route route;
  sim::Raycaster raycaster;
  sim::Lidar lidar;
  core::PoseTrajectory trajectory;
  double length_m = 0.0;
  std::vector<double> stamps_s;
  size_t next = 0;
};

DatasetRecorder::DatasetRecorder(const RecordOptions& options) : impl_(std::make_unique<Impl>(options)) {}
DatasetRecorder::~DatasetRecorder() = default;

const RecordOptions& DatasetRecorder::options() const {
  return impl_->options;
}
const scenes::SceneSpec& DatasetRecorder::scene() const {
  return impl_->scene;
}
const core::LidarModel& DatasetRecorder::lidar() const {
  return impl_->model;
}
const scenes::Route& DatasetRecorder::route() const {
  return impl_->route;
}
const core::PoseTrajectory& DatasetRecorder::trajectory() const {
  return impl_->trajectory;
}
double DatasetRecorder::length_m() const {
  return impl_->length_m;
}
const std::vector<double>& DatasetRecorder::stamps_s() const {
  return impl_->stamps_s;
}

bool DatasetRecorder::Next(core::SpinEvent* spin) {
  Impl& m = *impl_;
  if (m.next >= m.stamps_s.size()) return false;
  const double begin_s = m.stamps_s[m.next++], end_s = begin_s + 1.0 / m.model.spin_rate_hz;
  spin->T_odom_lidar = {};
  for (const core::StampedPose& pose : m.trajectory.poses()) {
    if (pose.time_s < begin_s - kTrajectoryStep_s) continue;
    spin->T_odom_lidar.Add(pose.time_s, pose.T);
    if (pose.time_s > end_s) break;
  }
  spin->scan = m.lidar.Spin(&m.raycaster, begin_s, spin->T_odom_lidar, nullptr, m.options.threads);
  return true;
}

std::vector<uint8_t> DatasetRecorder::SeenPoints(std::span<const core::Vec3f> points,
                                                 std::span<const core::Vec3f> normals) const {
  std::vector<core::StampedPose> poses;
  for (double stamp_s : impl_->stamps_s) poses.push_back({stamp_s, impl_->trajectory.At(stamp_s)});
  return experiments::SeenPoints(points, normals, poses, impl_->model, impl_->raycaster,
                                 impl_->options.threads);
}

void DatasetRecorder::Rewind() {
  impl_->next = 0;
  impl_->lidar = sim::Lidar(impl_->model, core::Rng(impl_->options.seed));
}

}  // namespace atlas::experiments
