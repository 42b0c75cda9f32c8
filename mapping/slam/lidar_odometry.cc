#include "mapping/slam/lidar_odometry.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "mapping/cloud/surface_cloud.h"
#include "mapping/cloud/surfel_map.h"
#include "mapping/slam/scan_motion.h"

namespace atlas::mapping {
namespace {

using core::Mat3;
using core::Pose;
using core::PoseTrajectory;
using core::Vec3;
using core::Vec3f;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

constexpr double kCoarseCells = 4.0;                 // of the coarse map, in cells of the fine one
constexpr double kAgainM = 0.05, kAgainRad = 0.009;  // changes above undistort the scan once more
constexpr double kThresholdSigmas = 3.0;
constexpr size_t kLeastPairs = 30;
constexpr double kUsualShare = 0.75;  // an overlap below this share of the usual one may be a wrong match

/// Standard deviations of a prior: of where it begins, and of its motion over the revolution.
struct PriorSigmas {
  double start_m = 0.0, start_rad = 0.0, motion_m = 0.0, motion_rad = 0.0;

  /// Inverse covariance of [start; end] as independent errors of the start and of the motion.
  Matrix12 Information() const {
    const auto inverse = [](double m, double rad) {
      core::Vec6 diagonal;
      diagonal << Vec3::Constant(1.0 / (m * m)), Vec3::Constant(1.0 / (rad * rad));
      return Matrix6(diagonal.asDiagonal());
    };
    const Matrix6 start = inverse(start_m, start_rad), motion = inverse(motion_m, motion_rad);
    Matrix12 information;
    information << start + motion, -motion, -motion, motion;
    return information;
  }
};

/// A scan made ready: undistorted by `correction`.
struct PreparedScan {
  SurfaceCloud cloud;          ///< in the LiDAR's frame at the end
  std::vector<uint8_t> slice;  ///< of each point
  ScanMotion::SlicePoses T_slice_end;
  ScanCorrection correction;
  size_t stride;  ///< each of so many points is matched
};

struct ScanSums {
  Matrix12 H = Matrix12::Zero();
  ScanCorrection b = ScanCorrection::Zero();
  Mat3 directions = Mat3::Zero();  ///< of map normals times scan normals, in the map
  double squares = 0.0, weights = 0.0;
  size_t pairs = 0, points = 0;
};

/// Point-to-plane distances to the map's surfels with Geman and McClure's kernel.
ScanSums SumsAt(const PreparedScan& scan, const SurfelMap& map, const ScanMotion& motion,
                const ScanCorrection& correction, double threshold_m) {
  ScanSums sums;
  const double kernel_sq = 0.25 * threshold_m * threshold_m;
  const ScanMotion::SlicePoses T_odom_slices = motion.PosesOf(correction);
  for (size_t i = 0; i < scan.cloud.size(); i += scan.stride) {
    if (scan.cloud.normals()[i].isZero()) continue;
    ++sums.points;
    const size_t slice = scan.slice[i];
    const Pose &T_odom_slice = T_odom_slices[slice], &T_slice_end = scan.T_slice_end[slice];
    const Vec3 p = T_slice_end * scan.cloud.points()[i].cast<double>(), p_odom = T_odom_slice * p;
    const Vec3 normal_odom =
        T_odom_slice.linear() * (T_slice_end.linear() * scan.cloud.normals()[i].cast<double>());
    const auto surfel =
        map.Nearest(p_odom.cast<float>(), normal_odom.cast<float>(), static_cast<float>(threshold_m));
    if (!surfel) continue;
    const Vec3 n_odom = surfel->normal.cast<double>(), n = T_odom_slice.linear().transpose() * n_odom;
    const double distance = n_odom.dot(p_odom - surfel->mean.cast<double>());
    const double root = kernel_sq / (kernel_sq + distance * distance), weight = root * root;
    Vector6 J;
    J << n, p.cross(n);
    const double end = motion.ShareOf(slice), start = 1.0 - end;
    const Matrix6 JJ = weight * J * J.transpose();
    sums.H.topLeftCorner<6, 6>() += start * start * JJ;
    sums.H.topRightCorner<6, 6>() += start * end * JJ;
    sums.H.bottomRightCorner<6, 6>() += end * end * JJ;
    sums.b.head<6>() += start * weight * distance * J;
    sums.b.tail<6>() += end * weight * distance * J;
    sums.directions += n_odom * normal_odom.transpose();
    sums.squares += weight * distance * distance;
    sums.weights += weight;
    ++sums.pairs;
  }
  sums.H.bottomLeftCorner<6, 6>() = sums.H.topRightCorner<6, 6>().transpose();
  return sums;
}

/// Directions (columns of axes) of the map, by what the pairs say along them.
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

/// Takes out of the scan's equations what they say of translations along weak directions: noise of normals.
void Silence(const Weakness& weakness, double min_eigenvalue, const Mat3& R_lidar_odom, ScanSums* sums) {
  Mat3 kept = Mat3::Identity();
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = R_lidar_odom * weakness.axes.col(k);
    if (weakness.eigenvalues[k] < min_eigenvalue) kept -= axis * axis.transpose();
  }
  Matrix12 P = Matrix12::Identity();
  P.block<3, 3>(0, 0) = P.block<3, 3>(6, 6) = kept;
  sums->H = P * sums->H * P;
  sums->b = P * sums->b;
}

/// The inverse covariance of the end, whatever the start.
Matrix6 InformationOfEnd(const Matrix12& H) {
  const Matrix6 cross = H.topRightCorner<6, 6>();
  return H.bottomRightCorner<6, 6>() - cross.transpose() * H.topLeftCorner<6, 6>().ldlt().solve(cross);
}

struct FirstScan {
  core::LidarScan scan;
  std::optional<PoseTrajectory> attitude;
};

}  // namespace

struct LidarOdometry::Impl {
  explicit Impl(const LidarOdometryParams& given) : params(given) {}

  LidarOdometryResult Track(const ScanMotion& motion, const PriorSigmas& sigmas);
  PreparedScan Prepare(const ScanMotion& motion, const ScanCorrection& correction) const;
  void Start(const SurfaceCloud& scan);
  void Match(const PreparedScan& scan, const ScanMotion& motion, const PriorSigmas& sigmas,
             ScanCorrection* correction, LidarOdometryResult* result) const;
  void Recover(const ScanMotion& motion, const PriorSigmas& sigmas, PreparedScan* scan,
               ScanCorrection* correction, LidarOdometryResult* result) const;
  void Grow(const PreparedScan& scan, const ScanMotion& motion, const ScanCorrection& correction);
  void AdaptThreshold(const Vector6& correction, double range_m);
  PoseTrajectory GoingOn(const core::LidarScan& scan, const PoseTrajectory* attitude) const;
  PriorSigmas SigmasGoingOn(const ScanMotion& motion, bool attitude) const;
  LidarOdometryResult TrackOneGoingOn(const core::LidarScan& scan, const PoseTrajectory* attitude);
  LidarOdometryResult TrackGoingOn(const core::LidarScan& scan, const PoseTrajectory* attitude);

  LidarOdometryParams params;
  std::vector<SurfelMap> maps;  ///< fine, coarse; empty before the first scan
  double deviation_sq = 0.0;    ///< running mean of corrections' squares, metres at the median range
  size_t scans = 0;
  Pose T_odom_prior = Pose::Identity();
  double usual_overlap = 0.0;              ///< running mean
  std::optional<core::StampedPose> last;   ///< T_odom_lidar at the end of the last scan
  std::optional<SurfaceCloud> last_cloud;  ///< in the LiDAR's frame then
  Vector6 velocity = Vector6::Zero();      ///< of the last motion, a second
  std::optional<FirstScan> first_scan;     ///< until the second has come, without a prior
};

PreparedScan LidarOdometry::Impl::Prepare(const ScanMotion& motion, const ScanCorrection& correction) const {
  constexpr double kThinning = 1.5;
  ScanMotion::Returns returns = motion.Undistorted(correction, params.max_range_m);
  const double voxel_m = kThinning * ChooseVoxel(returns.p_end, Vec3f::Zero());
  PreparedScan scan{SurfaceCloud(returns.p_end, {voxel_m, 12, params.threads, Vec3f::Zero()}),
                    {},
                    std::move(returns.T_slice_end),
                    correction,
                    1};
  scan.stride = std::max<size_t>(1, scan.cloud.size() / params.matched_points);
  for (const uint32_t i : scan.cloud.first_in_cell()) scan.slice.push_back(returns.slice[i]);
  return scan;
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

void LidarOdometry::Impl::Match(const PreparedScan& scan, const ScanMotion& motion, const PriorSigmas& sigmas,
                                ScanCorrection* correction, LidarOdometryResult* result) const {
  const double fine_m = maps[0].voxel_m(), coarse_m = maps[1].voxel_m();
  const double least_m = 0.5 * fine_m;
  const Matrix12 prior = sigmas.Information();
  double threshold_m = std::clamp(kThresholdSigmas * std::sqrt(deviation_sq), fine_m, coarse_m);
  result->tracked = false;
  for (int iteration = 0; iteration < params.max_iterations; ++iteration) {
    ScanSums sums = SumsAt(scan, maps[threshold_m > fine_m ? 1 : 0], motion, *correction, threshold_m);
    result->overlap = static_cast<double>(sums.pairs) / static_cast<double>(std::max<size_t>(sums.points, 1));
    if (sums.pairs < kLeastPairs) return;
    const double variance = std::max(1e-4, sums.squares / std::max(sums.weights, 1.0));
    const Weakness weakness = WeaknessOf(sums);
    Silence(weakness, params.min_eigenvalue,
            motion.Corrected(motion.end_s(), *correction).linear().transpose(), &sums);
    const Matrix12 H = sums.H / variance + prior;
    const ScanCorrection step = -H.ldlt().solve(sums.b / variance + prior * *correction);
    if (!step.allFinite()) return;
    *correction += step;
    result->rmse_m = std::sqrt(variance);
    result->min_eigenvalue = weakness.eigenvalues[0];
    result->degenerate = weakness.eigenvalues[0] < params.min_eigenvalue;
    result->weak_direction_odom = weakness.axes.col(0);
    // Neighbours share normals and means: their distances count half (InformationOf in loop_check.h).
    result->information = InformationOfEnd(sums.H / (2.0 * variance) + prior);
    result->tracked = true;
    const bool small =
        step.tail<6>().head<3>().norm() < params.converged_m && step.tail<3>().norm() < params.converged_rad;
    if (small && threshold_m <= least_m) return;
    threshold_m = std::max(least_m, 0.7 * threshold_m);
  }
}

/// Generalised ICP to the last scan, whose reach is wider, from the motion foreseen and from none. Kept where
/// more of the scan then meets the map.
void LidarOdometry::Impl::Recover(const ScanMotion& motion, const PriorSigmas& sigmas, PreparedScan* scan,
                                  ScanCorrection* correction, LidarOdometryResult* result) const {
  constexpr double kBetter = 0.05;
  if (!last_cloud || last_cloud->size() == 0) return;
  const Pose predicted = motion.Predicted(motion.end_s());
  for (const Pose& start : {Pose(last->T.inverse() * predicted), Pose::Identity()}) {
    RegistrationParams registration;
    registration.threads = params.threads;
    const RegistrationResult found = Register(*last_cloud, scan->cloud, start, registration);
    if (!found.converged || found.overlap < params.min_overlap) continue;
    ScanCorrection moved;
    moved << core::Log(predicted.inverse() * last->T * found.T_target_source), Vector6::Zero();
    moved.tail<6>() = moved.head<6>();
    PreparedScan again = Prepare(motion, moved);
    PriorSigmas freed = sigmas;
    freed.start_m = freed.start_rad = 1.0;
    LidarOdometryResult matched = *result;
    Match(again, motion, freed, &moved, &matched);
    if (!matched.tracked || (result->tracked && matched.overlap < result->overlap + kBetter)) continue;
    *scan = std::move(again);
    *correction = moved;
    *result = matched;
  }
}

void LidarOdometry::Impl::Grow(const PreparedScan& scan, const ScanMotion& motion,
                               const ScanCorrection& correction) {
  constexpr size_t kCropEvery = 20;
  std::vector<Eigen::Isometry3f> T_odom_end;
  for (const Pose& T_odom_slice : motion.PosesOf(correction))
    T_odom_end.push_back((T_odom_slice * scan.T_slice_end[T_odom_end.size()]).cast<float>());
  const Vec3f here = motion.Corrected(motion.end_s(), correction).translation().cast<float>();
  for (SurfelMap& map : maps) {
    if (scans % kCropEvery == 0) map.Crop(here, static_cast<float>(params.map_radius_m));
    for (size_t i = 0; i < scan.cloud.size(); ++i) {
      const Vec3f &p = scan.cloud.points()[i], &normal = scan.cloud.normals()[i];
      if (normal.isZero() || p.norm() > static_cast<float>(params.map_radius_m)) continue;
      const Eigen::Isometry3f& T = T_odom_end[scan.slice[i]];
      map.Insert(T * p, (T.linear() * normal).normalized());
    }
  }
}

/// As KISS-ICP (Vizzo et al. 2023) has it: the search's first distance follows how far priors were off.
void LidarOdometry::Impl::AdaptThreshold(const Vector6& correction, double range_m) {
  constexpr double kForget = 0.1;
  const double off_m = correction.head<3>().norm() +
                       2.0 * range_m * std::sin(0.5 * std::min(1.0, correction.tail<3>().norm()));
  deviation_sq += kForget * (off_m * off_m - deviation_sq);
}

LidarOdometryResult LidarOdometry::Impl::Track(const ScanMotion& motion, const PriorSigmas& sigmas) {
  LidarOdometryResult result;
  result.time_s = motion.end_s();
  ScanCorrection correction = ScanCorrection::Zero();
  PreparedScan scan = Prepare(motion, correction);
  if (maps.empty() && scan.cloud.size() > 0) {
    Start(scan.cloud);
  } else if (!maps.empty() && scan.cloud.size() > 0) {
    Match(scan, motion, sigmas, &correction, &result);
    if (!result.tracked || result.overlap < std::max(params.min_overlap, kUsualShare * usual_overlap))
      Recover(motion, sigmas, &scan, &correction, &result);
    if (!result.tracked || result.overlap < params.min_overlap) {
      result.tracked = false;
      result.information = InformationOfEnd(sigmas.Information());
      correction.setZero();
    }
    const Vector6 change = (correction - scan.correction).tail<6>();
    if (change.head<3>().norm() > kAgainM || change.tail<3>().norm() > kAgainRad) {
      scan = Prepare(motion, correction);
      if (result.tracked) Match(scan, motion, sigmas, &correction, &result);
    }
    AdaptThreshold(correction.tail<6>(), scan.cloud.voxel_m() / 1.5 * 40.0);
    usual_overlap += (scans < 5 ? 0.5 : 0.1) * (result.overlap - usual_overlap);
  }
  result.T_odom_lidar = motion.Corrected(result.time_s, correction);
  result.trajectory = motion.Trajectory(correction);
  if (!maps.empty()) Grow(scan, motion, correction);
  if (last && result.time_s > last->time_s)
    velocity = core::Log(last->T.inverse() * result.T_odom_lidar) / (result.time_s - last->time_s);
  last = core::StampedPose{result.time_s, result.T_odom_lidar};
  last_cloud = std::move(scan.cloud);
  ++scans;
  return result;
}

/// The last motion continued, its rotations those of a gyroscope where there is one.
PoseTrajectory LidarOdometry::Impl::GoingOn(const core::LidarScan& scan,
                                            const PoseTrajectory* attitude) const {
  const PoseTrajectory none;
  const ScanMotion times(scan, none, Pose::Identity());
  const core::StampedPose from = last.value_or(core::StampedPose{times.end_s(), Pose::Identity()});
  PoseTrajectory going_on;
  constexpr int kSteps = 16;
  for (int k = 0; k <= kSteps; ++k) {
    const double time_s = times.start_s() + (times.end_s() - times.start_s()) * k / kSteps;
    Pose T = from.T * core::Exp((time_s - from.time_s) * velocity);
    if (attitude != nullptr)
      T.linear() =
          from.T.linear() * attitude->At(from.time_s).linear().transpose() * attitude->At(time_s).linear();
    going_on.Add(time_s, T);
  }
  return going_on;
}

LidarOdometryResult LidarOdometry::Impl::TrackOneGoingOn(const core::LidarScan& scan,
                                                         const PoseTrajectory* attitude) {
  const PoseTrajectory going_on = GoingOn(scan, attitude);
  const ScanMotion motion(scan, going_on, Pose::Identity());
  return Track(motion, SigmasGoingOn(motion, attitude != nullptr));
}

PriorSigmas LidarOdometry::Impl::SigmasGoingOn(const ScanMotion& motion, bool attitude) const {
  constexpr double kStartM = 0.05, kStartRad = 0.02, kGyroRad = 0.001, kLeast_s = 0.05;
  constexpr double kUnknownM = 1.0, kUnknownRad = 0.3;  // the velocity at first
  const double gap_s = std::max(kLeast_s, motion.end_s() - (last ? last->time_s : motion.start_s()));
  PriorSigmas sigmas{kStartM, kStartRad, params.acceleration_m_s2 * gap_s * gap_s,
                     params.acceleration_rad_s2 * gap_s * gap_s};
  if (scans < 3) sigmas = {kStartM, kStartRad, kUnknownM, kUnknownRad};
  if (attitude) sigmas.motion_rad = kGyroRad;
  return sigmas;
}

LidarOdometryResult LidarOdometry::Impl::TrackGoingOn(const core::LidarScan& scan,
                                                      const PoseTrajectory* attitude) {
  constexpr int kFirstPasses = 3;
  LidarOdometryResult result;
  // How fast the first scan was moving is known with the second: it is undistorted then, and both again.
  const int passes = first_scan ? kFirstPasses : 1;
  for (int pass = 0; pass < passes; ++pass) {
    if (pass > 0) {
      maps.clear();
      last.reset();
      scans = 0;
      TrackOneGoingOn(first_scan->scan, first_scan->attitude ? &*first_scan->attitude : nullptr);
    }
    result = TrackOneGoingOn(scan, attitude);
  }
  first_scan.reset();
  if (scans == 1) {
    first_scan.emplace(FirstScan{scan, {}});
    if (attitude != nullptr) first_scan->attitude = *attitude;
  }
  return result;
}

LidarOdometry::LidarOdometry(const LidarOdometryParams& params) : impl_(std::make_unique<Impl>(params)) {}
LidarOdometry::~LidarOdometry() = default;

LidarOdometryResult LidarOdometry::Add(const core::SpinEvent& spin) {
  // A correction moves all of the revolution: were its start held where the last one ended, an error there
  // would come back with the other sign at its end, and so on from scan to scan.
  constexpr double kMotionM = 0.002, kMotionRad = 5e-4;
  const ScanMotion motion(spin.scan, spin.T_odom_lidar, impl_->T_odom_prior);
  LidarOdometryResult result = impl_->Track(
      motion, {impl_->params.prior_sigma_m, impl_->params.prior_sigma_rad, kMotionM, kMotionRad});
  result.T_odom_prior = result.T_odom_lidar * spin.T_odom_lidar.At(result.time_s).inverse();
  impl_->T_odom_prior = result.T_odom_prior;
  return result;
}

LidarOdometryResult LidarOdometry::Add(const core::LidarScan& scan) {
  return impl_->TrackGoingOn(scan, nullptr);
}

LidarOdometryResult LidarOdometry::Add(const core::LidarScan& scan, const PoseTrajectory& attitude) {
  return impl_->TrackGoingOn(scan, &attitude);
}

}  // namespace atlas::mapping
