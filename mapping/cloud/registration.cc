#include "mapping/cloud/registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "core/parallel_for.h"

namespace atlas::mapping {
namespace {

using core::Mat3;
using core::Pose;
using core::Vec3;
using core::Vec3f;

/// Of a surface's covariance across it to that along it (Segal et al.: epsilon).
constexpr double kThickness = 1e-3;
/// Sums are formed a block of points at a time, and of the blocks in order: as they would be by one thread.
constexpr size_t kBlock = 256;
constexpr double kShrink = 0.75;  ///< of the distance of pairs, from step to step
constexpr double kFinalVoxels = 2.0;
/// While pairs are far, a part of the source tells where to go.
constexpr size_t kCoarseStride = 4;

Mat3 Skew(const Vec3& v) {
  Mat3 S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

struct NormalEquations {
  Matrix6 H = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  size_t pairs = 0;

  void Add(const NormalEquations& other) {
    H += other.H;
    b += other.b;
    pairs += other.pairs;
  }
};

struct PairSums {
  Matrix6 hessian = Matrix6::Zero();
  Mat3 directions = Mat3::Zero();  ///< of target's normals times source's
  double squares = 0.0;
  size_t pairs = 0;

  void Add(const PairSums& other) {
    hessian += other.hessian;
    directions += other.directions;
    squares += other.squares;
    pairs += other.pairs;
  }
};

/// A source point with its partner, in the source's frame.
struct MatchedPoint {
  Vec3 p, normal;
  Vec3 normal_target;  ///< turned into the source's frame
  Vec3 error;          ///< from the partner to p
};

class Matcher {
 public:
  Matcher(const SurfaceCloud& target, const SurfaceCloud& source, const RegistrationParams& params)
      : target_(target), source_(source), params_(params) {}

  /// Calls use(matched point, sums) for each `stride`-th source point with a partner within max_distance_m.
  template <typename Sums, typename Use>
  Sums OverPairs(const Pose& T_target_source, double max_distance_m, size_t stride, const Use& use) const {
    const size_t count = (source_.size() + stride - 1) / stride, blocks = (count + kBlock - 1) / kBlock;
    std::vector<Sums> sums(blocks);
    core::ParallelFor(params_.threads, blocks, [&](size_t begin, size_t end, size_t) {
      for (size_t block = begin; block < end; ++block) {
        const size_t last = std::min(count, (block + 1) * kBlock);
        for (size_t i = block * kBlock; i < last; ++i) {
          MatchedPoint match;
          if (Match(T_target_source, i * stride, max_distance_m, &match)) use(match, &sums[block]);
        }
      }
    });
    Sums total;
    for (const Sums& part : sums) total.Add(part);
    return total;
  }

  double Overlap(const Pose& T_target_source, double max_distance_m) const {
    std::vector<uint8_t> met(source_.size(), 0);
    core::ParallelFor(params_.threads, met.size(), [&](size_t begin, size_t end, size_t) {
      for (size_t i = begin; i < end; ++i) {
        const Vec3f p = (T_target_source * source_.points()[i].cast<double>()).cast<float>();
        met[i] = target_.Nearest(p, static_cast<float>(max_distance_m)) >= 0;
      }
    });
    return static_cast<double>(std::count(met.begin(), met.end(), 1)) / static_cast<double>(met.size());
  }

 private:
  bool Match(const Pose& T, size_t i, double max_distance_m, MatchedPoint* match) const {
    match->normal = source_.normals()[i].cast<double>();
    if (match->normal.isZero()) return false;
    match->p = source_.points()[i].cast<double>();
    const Vec3 p_target = T * match->p;
    const int64_t partner = target_.Nearest(p_target.cast<float>(), static_cast<float>(max_distance_m));
    if (partner < 0) return false;
    const Vec3 n = target_.normals()[static_cast<size_t>(partner)].cast<double>();
    if (n.isZero()) return false;
    match->normal_target = T.linear().transpose() * n;
    if (params_.facing && match->normal_target.dot(match->normal) < 0.0) return false;
    const Vec3 q = target_.points()[static_cast<size_t>(partner)].cast<double>();
    match->error = T.linear().transpose() * (p_target - q);
    return true;
  }

  const SurfaceCloud& target_;
  const SurfaceCloud& source_;
  const RegistrationParams params_;
};

/// One pair's share: M the inverse of the summed covariances I - (1 - eps) n n^T of both surfaces, weighted
/// by Geman and McClure's kernel of the Mahalanobis distance.
void AddPlaneToPlane(const MatchedPoint& pair, double kernel_sq, NormalEquations* sums) {
  constexpr double a = 1.0 - kThickness;
  const Mat3 covariance = 2.0 * Mat3::Identity() - a * (pair.normal * pair.normal.transpose() +
                                                        pair.normal_target * pair.normal_target.transpose());
  Mat3 M = covariance.inverse();
  const double root = kernel_sq / (kernel_sq + pair.error.dot(M * pair.error));
  M *= root * root;
  const Mat3 MP = M * Skew(pair.p);
  const Vec3 Me = M * pair.error;
  sums->H.topLeftCorner<3, 3>() += M;
  sums->H.topRightCorner<3, 3>() -= MP;
  sums->H.bottomRightCorner<3, 3>() += Skew(pair.p).transpose() * MP;
  sums->b.head<3>() += Me;
  sums->b.tail<3>() += pair.p.cross(Me);
  ++sums->pairs;
}

void AddPointToPlane(const MatchedPoint& pair, PairSums* sums) {
  Vector6 J;
  J << pair.normal_target, pair.p.cross(pair.normal_target);
  sums->hessian += J * J.transpose();
  sums->directions += pair.normal_target * pair.normal.transpose();
  const double distance = pair.normal_target.dot(pair.error);
  sums->squares += distance * distance;
  ++sums->pairs;
}

/// Steps until they are small at the final distance.
void Align(const Matcher& matcher, double final_m, const RegistrationParams& params,
           RegistrationResult* result) {
  double distance_m = std::max(params.max_distance_m, final_m);
  for (; result->iterations < params.max_iterations; ++result->iterations) {
    const bool final = distance_m <= final_m;
    // Mahalanobis distance of a displacement across the surface by a quarter of the pairs' distance.
    const double kernel_sq = 0.25 * 0.25 * distance_m * distance_m / (2.0 * kThickness);
    NormalEquations sums = matcher.OverPairs<NormalEquations>(
        result->T_target_source, distance_m, final ? 1 : kCoarseStride,
        [&](const MatchedPoint& pair, NormalEquations* part) { AddPlaneToPlane(pair, kernel_sq, part); });
    if (sums.pairs < 6) return;
    sums.H.bottomLeftCorner<3, 3>() = sums.H.topRightCorner<3, 3>().transpose();
    const Vector6 step = -sums.H.ldlt().solve(sums.b);
    if (!step.allFinite()) return;
    result->T_target_source = Perturbed(result->T_target_source, step);
    const bool small =
        step.head<3>().norm() < params.converged_m && step.tail<3>().norm() < params.converged_rad;
    result->converged = final && small;
    if (result->converged) return;
    distance_m = std::max(final_m, kShrink * distance_m);
  }
}

void Judge(const Matcher& matcher, double final_m, RegistrationResult* result) {
  result->overlap = matcher.Overlap(result->T_target_source, final_m);
  const PairSums sums = matcher.OverPairs<PairSums>(result->T_target_source, final_m, 1, AddPointToPlane);
  result->inliers = sums.pairs;
  if (sums.pairs == 0) return;
  const auto pairs = static_cast<double>(sums.pairs);
  result->inlier_rmse_m = std::sqrt(sums.squares / pairs);
  result->hessian = sums.hessian;
  // The two normals of a pair err independently: their product's mean, unlike a square's, holds no noise,
  // which in a bare corridor looks like walls across it.
  const Eigen::SelfAdjointEigenSolver<Mat3> axes((sums.directions + sums.directions.transpose()) /
                                                 (2.0 * pairs));
  result->min_eigenvalue = axes.eigenvalues()[0];
  result->weak_direction_target = result->T_target_source.linear() * axes.eigenvectors().col(0);
}

}  // namespace

Pose Perturbed(const Pose& T, const Vector6& xi) {
  const Vec3 v = xi.head<3>(), w = xi.tail<3>();
  const double angle = w.norm();
  const Mat3 W = Skew(w);
  Mat3 R = Mat3::Identity(), V = Mat3::Identity();
  if (angle > 1e-6) {
    const double s = std::sin(angle) / angle, c = (1.0 - std::cos(angle)) / (angle * angle);
    R += s * W + c * W * W;
    V += c * W + (1.0 - s) / (angle * angle) * W * W;
  } else {
    R += W + 0.5 * W * W;
    V += 0.5 * W;
  }
  Pose out = core::MakePose(T.linear() * R, T.translation() + T.linear() * (V * v));
  out.linear() = Eigen::Quaterniond(out.linear()).normalized().toRotationMatrix();
  return out;
}

RegistrationResult Register(const SurfaceCloud& target, const SurfaceCloud& source,
                            const Pose& T_target_source_start, const RegistrationParams& params) {
  RegistrationResult result;
  result.T_target_source = T_target_source_start;
  if (target.size() == 0 || source.size() == 0) return result;
  const Matcher matcher(target, source, params);
  const double final_m = kFinalVoxels * std::max(target.voxel_m(), source.voxel_m());
  Align(matcher, final_m, params, &result);
  Judge(matcher, final_m, &result);
  result.degenerate = !(result.min_eigenvalue >= params.min_eigenvalue);
  return result;
}

}  // namespace atlas::mapping
