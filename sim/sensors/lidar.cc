#include "sim/sensors/lidar.h"

#include <cassert>

#include "core/parallel_for.h"

namespace atlas::sim {
namespace {

/// The robot's bodies stand still for a slice of the revolution: 20 ms at 10 Hz.
constexpr int kSlices = 5;
/// Slices begin at multiples of this many columns, so that packets of rays do not straddle rows.
constexpr int kColumnAlignment = 16;
/// A return this close to the robot's own surface is taken for the robot.
constexpr double kSelfMarginM = 0.02;
constexpr double kNoiseLimitSigmas = 3.0;

/// Columns [first, last) of a revolution.
struct Slice {
  int first, last;
};

std::vector<Slice> MakeSlices(int columns) {
  const int even = (columns + kSlices - 1) / kSlices;
  const int step = (even + kColumnAlignment - 1) / kColumnAlignment * kColumnAlignment;
  std::vector<Slice> slices;
  for (int first = 0; first < columns; first += step)
    slices.push_back({first, std::min(first + step, columns)});
  return slices;
}

core::LidarScan MakeScan(const core::LidarModel& model, double stamp_s,
                         const std::vector<core::Vec3f>& direction) {
  core::LidarScan scan;
  scan.stamp_s = stamp_s;
  scan.rows = model.rows();
  scan.columns = model.columns;
  scan.direction_lidar = direction;
  scan.range_m.assign(direction.size(), 0.0f);
  scan.time_s.resize(direction.size());
  scan.kind.assign(direction.size(), core::ReturnKind::kVoid);
  scan.min_range_m = static_cast<float>(model.min_range_m);
  scan.max_range_m = static_cast<float>(model.max_range_m);
  const double period_s = 1.0 / model.spin_rate_hz;
  for (size_t i = 0; i < direction.size(); ++i) {
    const auto column = static_cast<int>(i) % model.columns;
    scan.time_s[i] = static_cast<float>(period_s * column / model.columns);
  }
  return scan;
}

std::vector<Eigen::Isometry3f> PoseOfEachColumn(const core::LidarModel& model, double stamp_s,
                                                const core::PoseTrajectory& T_map_lidar) {
  std::vector<Eigen::Isometry3f> poses;
  poses.reserve(static_cast<size_t>(model.columns));
  for (int c = 0; c < model.columns; ++c) {
    poses.push_back(T_map_lidar.At(stamp_s + c / (model.spin_rate_hz * model.columns)).cast<float>());
  }
  return poses;
}

/// Counter-based noise, a stream each, so that no draw depends on the threads or on another ray.
struct SpinSeeds {
  uint64_t dropout, noise, transmission;
};

/// Everything about one slice that decides what its rays return.
struct SliceView {
  const core::LidarModel& model;
  const Raycaster& raycaster;
  SpinSeeds seeds;
  double body_reach_m;  ///< nothing of the robot is farther from the sensor
};

core::ReturnKind KindOf(const SliceView& view, const core::Ray& ray, const RayHit& hit, size_t index) {
  const core::LidarModel& model = view.model;
  if (core::UniformAt(view.seeds.dropout, index) < model.dropout_probability)
    return core::ReturnKind::kDropout;
  if (hit.range_m < 0.0f) return core::ReturnKind::kVoid;
  if (hit.part >= kMovingBody || hit.range_m < model.min_range_m) return core::ReturnKind::kDropout;
  if (hit.range_m <= view.body_reach_m + kSelfMarginM) {
    const core::Vec3 p_map = (ray.origin + hit.range_m * ray.direction).cast<double>();
    if (view.raycaster.NearBody(p_map, kSelfMarginM)) return core::ReturnKind::kDropout;
  }
  return core::ReturnKind::kHit;
}

float NoisyRange(const SliceView& view, float range_m, size_t index) {
  const core::LidarModel& model = view.model;
  const double sigmas =
      std::clamp(core::NormalAt(view.seeds.noise, index), -kNoiseLimitSigmas, kNoiseLimitSigmas);
  return static_cast<float>(
      std::clamp(range_m + model.range_sigma_m * sigmas, model.min_range_m, model.max_range_m));
}

}  // namespace

Lidar::Lidar(const core::LidarModel& model, const core::Rng& rng)
    : model_(model), noise_seed_(rng.Split("lidar").seed()) {
  direction_.reserve(static_cast<size_t>(model_.rows()) * static_cast<size_t>(model_.columns));
  for (size_t row = 0; row < model_.elevation_rad.size(); ++row) {
    const double elevation = model_.elevation_rad[row];
    for (int column = 0; column < model_.columns; ++column) {
      const double azimuth = -2.0 * core::kPi * column / model_.columns + model_.azimuth_offset_rad[row];
      direction_.push_back(core::Vec3(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
                               .cast<float>());
    }
  }
}

core::LidarScan Lidar::Spin(Raycaster* raycaster, double stamp_s, const core::PoseTrajectory& T_map_lidar,
                            const std::function<void(double)>& pose_bodies_at, int threads) {
  assert(!T_map_lidar.empty());
  core::LidarScan scan = MakeScan(model_, stamp_s, direction_);
  const std::vector<Eigen::Isometry3f> T_map_column = PoseOfEachColumn(model_, stamp_s, T_map_lidar);
  const uint64_t spin = 3 * spin_count_++;
  SliceView view{model_,
                 *raycaster,
                 {core::HashCounter(noise_seed_, spin), core::HashCounter(noise_seed_, spin + 1),
                  core::HashCounter(noise_seed_, spin + 2)},
                 0.0};
  const auto columns = static_cast<size_t>(model_.columns);
  std::vector<core::Ray> rays;
  std::vector<RayHit> hits;
  for (const Slice& slice : MakeSlices(model_.columns)) {
    const auto first = static_cast<size_t>(slice.first), width = static_cast<size_t>(slice.last) - first;
    const double middle = 0.5 * (slice.first + slice.last) / model_.columns;
    if (pose_bodies_at) pose_bodies_at(stamp_s + middle / model_.spin_rate_hz);
    raycaster->CommitPoses();
    view.body_reach_m = raycaster->BodyReach(T_map_column[first].translation().cast<double>());

    const size_t count = width * static_cast<size_t>(model_.rows());
    const auto index_of = [&](size_t k) { return k / width * columns + first + k % width; };  // in the scan
    rays.resize(count);
    hits.resize(count);
    for (size_t k = 0; k < count; ++k) {
      const Eigen::Isometry3f& T = T_map_column[first + k % width];
      rays[k] = {T.translation(), T.linear() * direction_[index_of(k)]};
    }
    raycaster->Cast(rays, scan.max_range_m, core::HashCounter(view.seeds.transmission, first), threads, hits);
    core::ParallelFor(threads, count, [&](size_t begin, size_t end, size_t) {
      for (size_t k = begin; k < end; ++k) {
        const size_t i = index_of(k);
        scan.kind[i] = KindOf(view, rays[k], hits[k], i);
        if (scan.kind[i] == core::ReturnKind::kHit) scan.range_m[i] = NoisyRange(view, hits[k].range_m, i);
      }
    });
  }
  return scan;
}

}  // namespace atlas::sim
