#include "experiments/judge/align.h"

#include <cmath>
#include <vector>

namespace atlas::experiments {
namespace {

using core::Pose;
using core::Vec3;
using core::Vec3f;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Points with truth nearby, about `count` of them, evenly over the cloud.
std::vector<Vec3f> PointsNearTruth(std::span<const Vec3f> cloud, const PointGrid& truth, const Pose& T,
                                   int count, double gate_m) {
  const auto near = [&](size_t i) {
    float distance = 0.0f;
    const Vec3f p = (T * cloud[i].cast<double>()).cast<float>();
    return truth.Nearest(p, static_cast<float>(gate_m), &distance) >= 0;
  };
  // A first look at one point in many tells how dense the useful ones lie.
  const size_t probe = std::max<size_t>(1, cloud.size() / 4000);
  size_t looked = 0, found = 0;
  for (size_t i = 0; i < cloud.size(); i += probe, ++looked) found += near(i);
  const double useful = static_cast<double>(found) / static_cast<double>(std::max<size_t>(looked, 1)) *
                        static_cast<double>(cloud.size());
  const size_t stride = std::max<size_t>(1, static_cast<size_t>(useful / count));
  std::vector<Vec3f> chosen;
  for (size_t i = 0; i < cloud.size(); i += stride) {
    if (near(i)) chosen.push_back(cloud[i]);
  }
  return chosen;
}

struct Normal {
  Mat6 H = Mat6::Zero();
  Vec6 g = Vec6::Zero();
  double weight = 0.0, squares = 0.0;
  int pairs = 0;
};

/// Gauss-Newton terms of sum w (n . (T p - q))^2 about a rotation centre, twist (rotation, translation) on
/// the left.
Normal Linearise(const std::vector<Vec3f>& points, const PointGrid& truth,
                 std::span<const Vec3f> truth_points, std::span<const Vec3f> truth_normals, const Pose& T,
                 const Vec3& center, double gate_m, double scale_m) {
  Normal sum;
  for (const Vec3f& point : points) {
    const Vec3 p = T * point.cast<double>();
    float distance = 0.0f;
    const int64_t i = truth.Nearest(p.cast<float>(), static_cast<float>(gate_m), &distance);
    if (i < 0) continue;
    const Vec3 n = truth_normals[static_cast<size_t>(i)].cast<double>();
    const double r = n.dot(p - truth_points[static_cast<size_t>(i)].cast<double>());
    const double w = 1.0 / (1.0 + (r / scale_m) * (r / scale_m));
    Vec6 J;
    J << (p - center).cross(n), n;
    sum.H.noalias() += w * J * J.transpose();
    sum.g.noalias() += w * r * J;
    sum.weight += w;
    sum.squares += w * r * r;
    ++sum.pairs;
  }
  return sum;
}

Vec3 MeanOf(const std::vector<Vec3f>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& p : points) mean += p.cast<double>();
  return mean / static_cast<double>(std::max<size_t>(points.size(), 1));
}

Pose TwistAbout(const Vec3& center, const Vec6& x) {
  const Vec3 w = x.head<3>();
  const double angle = w.norm();
  const core::Mat3 R =
      angle > 0.0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : core::Mat3::Identity().eval();
  return core::MakePose(R, center + x.tail<3>() - R * center);
}

}  // namespace

AlignResult AlignToTruth(std::span<const Vec3f> cloud, const PointGrid& truth,
                         std::span<const Vec3f> truth_points, std::span<const Vec3f> truth_normals,
                         const Pose& T_start, const AlignOptions& options) {
  AlignResult result{.T_truth_cloud = T_start};
  const std::vector<Vec3f> points =
      PointsNearTruth(cloud, truth, T_start, options.correspondences, options.first_gate_m);
  const Vec3 center = T_start * MeanOf(points);
  double reach_sq = 1.0;  // mean squared lever arm: what a radian moves, so that the prior is in metres
  for (const Vec3f& p : points) {
    reach_sq += (T_start * p.cast<double>() - center).squaredNorm() / static_cast<double>(points.size());
  }
  Vec6 prior_scale;
  prior_scale << Vec3::Constant(reach_sq), Vec3::Ones();

  double gate = options.first_gate_m;
  Pose T = T_start;
  for (int round = 0; round < options.max_iterations; ++round) {
    Normal n = Linearise(points, truth, truth_points, truth_normals, T, center, gate, options.robust_scale_m);
    if (n.pairs < 100) return result;
    n.H.diagonal() += options.prior_share * n.weight * prior_scale;
    const Pose step = TwistAbout(center, -n.H.ldlt().solve(n.g));
    T = step * T;
    result = {.T_truth_cloud = T, .pairs = n.pairs, .rms_m = std::sqrt(n.squares / n.weight)};
    const bool settled = (step.matrix() - Pose::Identity().matrix()).cwiseAbs().maxCoeff() < 2e-5;
    if (settled && gate <= options.last_gate_m) break;
    gate = std::max(0.5 * gate, options.last_gate_m);
  }
  return result;
}

}  // namespace atlas::experiments
