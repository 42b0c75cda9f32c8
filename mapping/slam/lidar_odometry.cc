#include "mapping/slam/lidar_odometry.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <vector>

#include "mapping/cloud/surface_cloud.h"
#include "mapping/cloud/surfel_map.h"
#include "mapping/slam/loop_check.h"

namespace atlas::mapping {
namespace {

using core::Mat3;
using core::Pose;
using core::PoseTrajectory;
using core::Vec3;
using core::Vec3f;

constexpr size_t kSlices = 512;                      // of a revolution, each with one pose
constexpr double kCoarseCells = 4.0;                 // of the coarse map, in cells of the fine one
constexpr double kAgainM = 0.02, kAgainRad = 0.004;  // corrections above undistort the scan once more
constexpr double kThresholdSigmas = 3.0;

/// The revolution's motion: the prior's, and what the scan adds to it, which grows evenly from its start.
class ScanMotion {
 public:
  ScanMotion(const core::LidarScan& scan, const PoseTrajectory& T_prior_lidar, const Pose& T_odom_prior)
      : scan_(scan), T_prior_lidar_(T_prior_lidar), T_odom_prior_(T_odom_prior) {
    for (const float t : scan.time_s) duration_s_ = std::max(duration_s_, static_cast<double>(t));
  }

  double end_s() const { return scan_.stamp_s + duration_s_; }
  Pose Predicted(double time_s) const { return T_odom_prior_ * T_prior_lidar_.At(time_s); }
  Pose Corrected(double time_s, const Vector6& correction) const {
    const double u = duration_s_ > 0.0 ? std::clamp((time_s - scan_.stamp_s) / duration_s_, 0.0, 1.0) : 1.0;
    return Perturbed(Predicted(time_s), u * correction);
  }

  /// The returns in the frame of the LiDAR at the end.
  std::vector<Vec3f> Undistorted(const Vector6& correction, double max_range_m) const {
    const Pose T_end_odom = Corrected(end_s(), correction).inverse();
    std::array<Eigen::Isometry3f, kSlices> T_end_slice;
    for (size_t k = 0; k < kSlices; ++k) {
      const double time_s = scan_.stamp_s + duration_s_ * (static_cast<double>(k) + 0.5) / kSlices;
      T_end_slice[k] = (T_end_odom * Corrected(time_s, correction)).cast<float>();
    }
    std::vector<Vec3f> points;
    const float to_slice = duration_s_ > 0.0 ? static_cast<float>(kSlices / duration_s_) : 0.0f;
    for (size_t i = 0; i < scan_.size(); ++i) {
      if (scan_.kind[i] != core::ReturnKind::kHit || static_cast<double>(scan_.range_m[i]) > max_range_m)
        continue;
      const auto slice =
          std::min(kSlices - 1, static_cast<size_t>(std::max(0.0f, scan_.time_s[i] * to_slice)));
      points.push_back(T_end_slice[slice] * (scan_.range_m[i] * scan_.direction_lidar[i]));
    }
    return points;
  }

  PoseTrajectory Trajectory(const Vector6& correction) const {
    PoseTrajectory trajectory;
    trajectory.Add(scan_.stamp_s, Corrected(scan_.stamp_s, correction));
    for (const core::StampedPose& pose : T_prior_lidar_.poses()) {
      if (pose.time_s > scan_.stamp_s && pose.time_s < end_s())
        trajectory.Add(pose.time_s, Corrected(pose.time_s, correction));
    }
    if (end_s() > scan_.stamp_s) trajectory.Add(end_s(), Corrected(end_s(), correction));
    return trajectory;
  }

 private:
  const core::LidarScan& scan_;
  const PoseTrajectory& T_prior_lidar_;
  Pose T_odom_prior_;
  double duration_s_ = 0.0;
};

struct ScanSums {
  Matrix6 H = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  Mat3 directions = Mat3::Zero();  ///< of map normals times scan normals, in the LiDAR's frame
  double squares = 0.0, weights = 0.0;
  size_t pairs = 0, points = 0;
};

/// Point-to-plane distances to the map's surfels with Geman and McClure's kernel.
ScanSums SumsAt(const SurfaceCloud& scan, size_t stride, const SurfelMap& map, const Pose& T_odom_lidar,
                double threshold_m) {
  ScanSums sums;
  const double kernel_sq = 0.25 * threshold_m * threshold_m;
  const Mat3 R_lidar_odom = T_odom_lidar.linear().transpose();
  for (size_t i = 0; i < scan.size(); i += stride) {
    const Vec3 normal = scan.normals()[i].cast<double>();
    if (normal.isZero()) continue;
    ++sums.points;
    const Vec3 p = scan.points()[i].cast<double>();
    const Vec3 p_odom = T_odom_lidar * p;
    const auto surfel = map.Nearest(p_odom.cast<float>(), (T_odom_lidar.linear() * normal).cast<float>(),
                                    static_cast<float>(threshold_m));
    if (!surfel) continue;
    const Vec3 n = R_lidar_odom * surfel->normal.cast<double>();
    const double distance = surfel->normal.cast<double>().dot(p_odom - surfel->mean.cast<double>());
    const double root = kernel_sq / (kernel_sq + distance * distance), weight = root * root;
    Vector6 J;
    J << n, p.cross(n);
    sums.H += weight * J * J.transpose();
    sums.b += weight * distance * J;
    sums.directions += n * normal.transpose();
    sums.squares += weight * distance * distance;
    sums.weights += weight;
    ++sums.pairs;
  }
  return sums;
}

/// Directions (columns of axes) of the LiDAR's frame, by what the pairs say along them.
struct Weakness {
  Vec3 eigenvalues = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};
Weakness WeaknessOf(const ScanSums& sums) {
  if (sums.pairs == 0) return {};
  const Eigen::SelfAdjointEigenSolver<Mat3> solver((sums.directions + sums.directions.transpose()) /
                                                   (2.0 * static_cast<double>(sums.pairs)));
  return {solver.eigenvalues(), solver.eigenvectors()};
}

/// Adds to the scan's equations, in units of its distances' variance, what the prior knows of the whole
/// correction; along weak directions the prior alone decides.
void AddPrior(const Weakness& weakness, const Vector6& correction, double variance,
              const LidarOdometryParams& params, ScanSums* sums) {
  constexpr double kHard = 1e6;
  Matrix6 prior = Matrix6::Zero();
  prior.topLeftCorner<3, 3>() = Mat3::Identity() * variance / (params.prior_sigma_m * params.prior_sigma_m);
  prior.bottomRightCorner<3, 3>() =
      Mat3::Identity() * variance / (params.prior_sigma_rad * params.prior_sigma_rad);
  for (int k = 0; k < 3; ++k) {
    if (weakness.eigenvalues[k] >= params.min_eigenvalue) continue;
    const Vec3 axis = weakness.axes.col(k);
    prior.topLeftCorner<3, 3>() += kHard * static_cast<double>(sums->pairs + 1) * axis * axis.transpose();
  }
  sums->H += prior;
  sums->b += prior * correction;
}

}  // namespace

struct LidarOdometry::Impl {
  explicit Impl(const LidarOdometryParams& given) : params(given) {}

  LidarOdometryResult Track(const core::LidarScan& scan, const PoseTrajectory& T_prior_lidar);
  SurfaceCloud Prepare(const ScanMotion& motion, const Vector6& correction) const;
  void Start(const SurfaceCloud& scan);
  void Match(const SurfaceCloud& scan, const Pose& predicted, Vector6* correction,
             LidarOdometryResult* result) const;
  void Grow(const SurfaceCloud& scan, const Pose& T_odom_lidar);
  void AdaptThreshold(const Vector6& correction, double range_m);

  LidarOdometryParams params;
  std::vector<SurfelMap> maps;  ///< fine, coarse; empty before the first scan
  double deviation_sq = 0.0;    ///< running mean of corrections' squares, metres at the median range
  size_t scans = 0;
  Pose T_odom_prior = Pose::Identity();
  std::optional<core::StampedPose> last;  ///< T_odom_lidar at the end of the last scan
  Vector6 velocity = Vector6::Zero();     ///< of the last scan, a second
};

SurfaceCloud LidarOdometry::Impl::Prepare(const ScanMotion& motion, const Vector6& correction) const {
  constexpr double kThinning = 1.5;
  const std::vector<Vec3f> points = motion.Undistorted(correction, params.max_range_m);
  const double voxel_m = kThinning * ChooseVoxel(points, Vec3f::Zero());
  return SurfaceCloud(points, {voxel_m, 12, params.threads, Vec3f::Zero()});
}

void LidarOdometry::Impl::Start(const SurfaceCloud& scan) {
  constexpr double kCellsToMedian = 15.0;
  double voxel_m = params.voxel_m;
  if (voxel_m <= 0.0) {
    // SurfaceCloud's voxel is 1.5 / 40 of the median range within ChooseVoxel's limits.
    voxel_m = std::clamp(scan.voxel_m() / 1.5 * 40.0 / kCellsToMedian, 0.2, 0.6);
  }
  maps.emplace_back(voxel_m);
  maps.emplace_back(kCoarseCells * voxel_m);
  deviation_sq = voxel_m * voxel_m;
}

void LidarOdometry::Impl::Match(const SurfaceCloud& scan, const Pose& predicted, Vector6* correction,
                                LidarOdometryResult* result) const {
  const size_t stride = std::max<size_t>(1, scan.size() / params.matched_points);
  const double fine_m = maps[0].voxel_m(), coarse_m = maps[1].voxel_m();
  const double least_m = 0.5 * fine_m;
  double threshold_m = std::clamp(kThresholdSigmas * std::sqrt(deviation_sq), fine_m, coarse_m);
  Pose T = Perturbed(predicted, *correction);
  for (int iteration = 0; iteration < params.max_iterations; ++iteration) {
    ScanSums sums = SumsAt(scan, stride, maps[threshold_m > fine_m ? 1 : 0], T, threshold_m);
    result->overlap = static_cast<double>(sums.pairs) / static_cast<double>(std::max<size_t>(sums.points, 1));
    if (sums.pairs < 30) return;
    const double variance = std::max(1e-4, sums.squares / std::max(sums.weights, 1.0));
    const Weakness weakness = WeaknessOf(sums);
    AddPrior(weakness, *correction, variance, params, &sums);
    const Vector6 step = -sums.H.ldlt().solve(sums.b);
    if (!step.allFinite()) return;
    T = Perturbed(T, step);
    *correction = Difference(predicted, T);
    result->rmse_m = std::sqrt(variance);
    result->min_eigenvalue = weakness.eigenvalues[0];
    result->degenerate = weakness.eigenvalues[0] < params.min_eigenvalue;
    result->weak_direction_odom = T.linear() * weakness.axes.col(0);
    result->information = sums.H / (2.0 * variance);
    result->tracked = true;
    const bool small =
        step.head<3>().norm() < params.converged_m && step.tail<3>().norm() < params.converged_rad;
    if (small && threshold_m <= least_m) return;
    threshold_m = std::max(least_m, 0.7 * threshold_m);
  }
}

void LidarOdometry::Impl::Grow(const SurfaceCloud& scan, const Pose& T_odom_lidar) {
  constexpr size_t kCropEvery = 20;
  const Eigen::Isometry3f T = T_odom_lidar.cast<float>();
  for (SurfelMap& map : maps) {
    if (scans % kCropEvery == 0) map.Crop(T.translation(), static_cast<float>(params.map_radius_m));
    for (size_t i = 0; i < scan.size(); ++i) {
      if (scan.normals()[i].isZero() || scan.points()[i].norm() > static_cast<float>(params.map_radius_m))
        continue;
      map.Insert(T * scan.points()[i], T.linear() * scan.normals()[i]);
    }
  }
}

/// As KISS-ICP (Vizzo et al. 2023) has it: the search's first distance follows how far priors were off.
void LidarOdometry::Impl::AdaptThreshold(const Vector6& correction, double range_m) {
  constexpr double kForget = 0.1;
  const double off_m =
      correction.head<3>().norm() + 2.0 * range_m * std::sin(0.5 * correction.tail<3>().norm());
  deviation_sq += kForget * (off_m * off_m - deviation_sq);
}

LidarOdometryResult LidarOdometry::Impl::Track(const core::LidarScan& scan,
                                               const PoseTrajectory& T_prior_lidar) {
  const ScanMotion motion(scan, T_prior_lidar, T_odom_prior);
  LidarOdometryResult result;
  result.time_s = motion.end_s();
  const Pose predicted = motion.Predicted(result.time_s);
  Vector6 correction = Vector6::Zero();
  SurfaceCloud cloud = Prepare(motion, correction);
  if (maps.empty() && cloud.size() > 0) {
    Start(cloud);
  } else if (!maps.empty() && cloud.size() > 0) {
    Match(cloud, predicted, &correction, &result);
    if (correction.head<3>().norm() > kAgainM || correction.tail<3>().norm() > kAgainRad) {
      cloud = Prepare(motion, correction);
      Match(cloud, predicted, &correction, &result);
    }
    AdaptThreshold(correction, cloud.voxel_m() / 1.5 * 40.0);
  }
  result.T_odom_lidar = motion.Corrected(result.time_s, correction);
  result.T_odom_prior = result.T_odom_lidar * T_prior_lidar.At(result.time_s).inverse();
  result.trajectory = motion.Trajectory(correction);
  if (!maps.empty()) Grow(cloud, result.T_odom_lidar);
  T_odom_prior = result.T_odom_prior;
  const Pose start = result.trajectory.poses().front().T;
  const double duration_s = result.time_s - scan.stamp_s;
  if (duration_s > 0.0) velocity = Difference(start, result.T_odom_lidar) / duration_s;
  last = core::StampedPose{result.time_s, result.T_odom_lidar};
  ++scans;
  return result;
}

LidarOdometry::LidarOdometry(const LidarOdometryParams& params) : impl_(std::make_unique<Impl>(params)) {}
LidarOdometry::~LidarOdometry() = default;

LidarOdometryResult LidarOdometry::Add(const core::SpinEvent& spin) {
  return impl_->Track(spin.scan, spin.T_odom_lidar);
}

LidarOdometryResult LidarOdometry::Add(const core::LidarScan& scan) {
  float duration_s = 0.0f;
  for (const float t : scan.time_s) duration_s = std::max(duration_s, t);
  PoseTrajectory going_on;
  const core::StampedPose from = impl_->last.value_or(core::StampedPose{scan.stamp_s, Pose::Identity()});
  constexpr int kSteps = 8;
  for (int k = 0; k <= kSteps; ++k) {
    const double time_s = scan.stamp_s + static_cast<double>(duration_s) * k / kSteps;
    going_on.Add(time_s, Perturbed(from.T, (time_s - from.time_s) * impl_->velocity));
  }
  impl_->T_odom_prior = Pose::Identity();
  return impl_->Track(scan, going_on);
}

}  // namespace atlas::mapping
