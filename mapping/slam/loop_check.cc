#include "mapping/slam/loop_check.h"

#include <algorithm>

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3f;

/// What one keyframe says of the other's points.
struct Sighting {
  double overlap = 0.0, agreement = 0.0, in_front = 0.0, shared = 0.0;
};

/// Whether two points with normals, in one frame, lie on one surface.
bool OnOneSurface(const Vec3f& p, const Vec3f& n, const Vec3f& q, const Vec3f& m, float tolerance_m) {
  constexpr float kLeastCosine = 0.7f;
  return n.dot(m) > kLeastCosine && std::abs(m.dot(p - q)) < tolerance_m;
}

Sighting Look(const LoopScan& from, const LoopScan& at, const Pose& T_from_at) {
  constexpr float kBesideVoxels = 2.0f, kSurfaceVoxels = 0.25f;
  const Eigen::Isometry3f T = T_from_at.cast<float>();
  const float voxel_m = static_cast<float>(std::max(from.cloud.voxel_m(), at.cloud.voxel_m()));
  size_t beside = 0, agreeing = 0, in_front = 0, seen = 0;
  for (size_t i = 0; i < at.cloud.size(); ++i) {
    const Vec3f p = T * at.cloud.points()[i];
    // Directions are coarse: far away, surfaces seen at a grazing angle spread over a cell.
    const RangeView::Sight sight = from.view.Of(p, 2.0f * voxel_m + 0.03f * p.norm());
    const int64_t nearest = from.cloud.Nearest(p, kBesideVoxels * voxel_m);
    if (nearest >= 0) {
      const auto k = static_cast<size_t>(nearest);
      ++beside;
      agreeing += OnOneSurface(p, T.linear() * at.cloud.normals()[i], from.cloud.points()[k],
                               from.cloud.normals()[k], kSurfaceVoxels * voxel_m);
    }
    in_front += nearest < 0 && sight == RangeView::Sight::kInFront;
    seen += nearest >= 0 || sight == RangeView::Sight::kInFront || sight == RangeView::Sight::kAtSurface;
  }
  if (seen == 0) return {};
  const auto share = [](size_t part, size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  return {share(beside, seen), share(agreeing, seen), share(in_front, seen), share(beside, at.cloud.size())};
}

bool InGate(const Pose& T_a_b, const LoopEstimate& estimate, double max_gate_sq) {
  const Vector6 xi = Difference(estimate.T_a_b, T_a_b);
  return xi.dot(estimate.covariance.ldlt().solve(xi)) <= max_gate_sq;
}

LoopVerdict VerdictOf(const LoopCheckResult& result, double shared, double voxel_m,
                      const LoopCheckParams& params) {
  if (!result.registration.converged) return LoopVerdict::kNotConverged;
  if (result.registration.degenerate) return LoopVerdict::kDegenerate;
  if (result.registration.inlier_rmse_m >= params.max_rmse_voxels * voxel_m) return LoopVerdict::kRmse;
  if (result.overlap < params.min_overlap || result.agreement < params.min_agreement ||
      shared < params.min_shared)
    return LoopVerdict::kOverlap;
  if (result.in_front > params.max_in_front) return LoopVerdict::kInFront;
  return LoopVerdict::kAccepted;
}

LoopCheckResult CheckFrom(const LoopScan& a, const LoopScan& b, const Pose& T_a_b_start,
                          const std::optional<LoopEstimate>& estimate, const LoopCheckParams& params) {
  LoopCheckResult result;
  result.registration = Register(a.cloud, b.cloud, T_a_b_start, params.registration);
  result.T_a_b = result.registration.T_target_source;
  const Sighting of_b = Look(a, b, result.T_a_b), of_a = Look(b, a, result.T_a_b.inverse());
  result.overlap = std::min(of_a.overlap, of_b.overlap);
  result.agreement = std::min(of_a.agreement, of_b.agreement);
  result.in_front = std::max(of_a.in_front, of_b.in_front);
  const double voxel_m = std::max(a.cloud.voxel_m(), b.cloud.voxel_m());
  result.verdict = VerdictOf(result, std::min(of_a.shared, of_b.shared), voxel_m, params);
  if (result.accepted() && estimate && !InGate(result.T_a_b, *estimate, params.max_gate_sq))
    result.verdict = LoopVerdict::kGate;
  return result;
}

bool Same(const Pose& T, const Pose& other, const LoopCheckParams& params) {
  const Pose between = T.inverse() * other;
  return between.translation().norm() <= params.same_m &&
         Eigen::AngleAxisd(between.linear()).angle() <= core::Radians(params.same_deg);
}

}  // namespace

RangeView::RangeView(std::span<const Vec3f> p_here) {
  constexpr float kMost = 65535.0f;
  std::vector<uint16_t> nearest(kCells, 0), farthest(kCells, 0);
  for (const Vec3f& p : p_here) {
    const float range = p.norm();
    if (!(range > 0.0f) || !std::isfinite(range)) continue;
    const size_t cell = CellOf(p, range);
    const auto units = static_cast<uint16_t>(std::clamp(std::round(range / kUnit_m), 1.0f, kMost));
    if (nearest[cell] == 0 || units < nearest[cell]) nearest[cell] = units;
    farthest[cell] = std::max(farthest[cell], units);
  }
  nearest_ = nearest;
  farthest_ = farthest;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const size_t cell = static_cast<size_t>(row * kColumns + column);
      if (nearest[cell] == 0) continue;  // past the field of view's edge nothing passed
      for (int r = std::max(0, row - 1); r <= std::min(kRows - 1, row + 1); ++r) {
        for (const int dc : {-1, 0, 1}) {
          const size_t at = static_cast<size_t>(r * kColumns + (column + dc + kColumns) % kColumns);
          if (nearest[at] == 0) continue;
          nearest_[cell] = std::min(nearest_[cell], nearest[at]);
          farthest_[cell] = std::max(farthest_[cell], farthest[at]);
        }
      }
    }
  }
}

size_t RangeView::CellOf(const Vec3f& p, float range_m) {
  const float pi = static_cast<float>(core::kPi);
  const float azimuth = (std::atan2(p.y(), p.x()) + pi) / (2.0f * pi);
  const float elevation = std::asin(std::clamp(p.z() / range_m, -1.0f, 1.0f)) / pi + 0.5f;
  const int column = std::min(kColumns - 1, static_cast<int>(azimuth * kColumns));
  const int row = std::min(kRows - 1, static_cast<int>(elevation * kRows));
  return static_cast<size_t>(row * kColumns + column);
}

RangeView::Sight RangeView::Of(const Vec3f& p_here, float margin_m) const {
  const float range = p_here.norm();
  if (!(range > 0.0f)) return Sight::kUnknown;
  const size_t cell = CellOf(p_here, range);
  if (nearest_[cell] == 0) return Sight::kUnknown;
  if (range < kUnit_m * static_cast<float>(nearest_[cell]) - margin_m) return Sight::kInFront;
  return range > kUnit_m * static_cast<float>(farthest_[cell]) + margin_m ? Sight::kHidden
                                                                          : Sight::kAtSurface;
}

LoopScan PrepareLoopScan(std::span<const Vec3f> p_here, const SurfaceCloudParams& params) {
  return {SurfaceCloud(p_here, params), RangeView(p_here)};
}

std::string_view NameOf(LoopVerdict verdict) {
  switch (verdict) {
    case LoopVerdict::kAccepted:
      return "accepted";
    case LoopVerdict::kNotConverged:
      return "not converged";
    case LoopVerdict::kDegenerate:
      return "degenerate";
    case LoopVerdict::kRmse:
      return "distances of the inliers";
    case LoopVerdict::kOverlap:
      return "overlap";
    case LoopVerdict::kInFront:
      return "points where beams passed";
    case LoopVerdict::kGate:
      return "outside the gate";
    case LoopVerdict::kAmbiguous:
      return "ambiguous";
  }
  return "";
}

Matrix6 InformationOf(const RegistrationResult& registration, double floor_m, double floor_deg) {
  constexpr double kShared = 2.0, kLeastSigma_m = 0.005;
  const double sigma_m = std::max(registration.inlier_rmse_m, kLeastSigma_m);
  const Matrix6 precision = registration.hessian / (kShared * sigma_m * sigma_m);
  Vector6 floor;
  floor << core::Vec3::Constant(floor_m), core::Vec3::Constant(core::Radians(floor_deg));
  const Matrix6 covariance =
      precision.ldlt().solve(Matrix6::Identity()) + Matrix6(floor.cwiseAbs2().asDiagonal());
  const Matrix6 information = covariance.ldlt().solve(Matrix6::Identity());
  return 0.5 * (information + information.transpose());
}

Vector6 Difference(const Pose& T, const Pose& other) {
  const Pose between = T.inverse() * other;
  const Eigen::AngleAxisd turn(between.linear());
  const double angle = turn.angle();
  const core::Vec3 w = angle * turn.axis(), t = between.translation();
  // V^-1 of V in Exp's translation V v.
  const double half = 0.5 * angle;
  const double c = angle < 1e-6 ? 1.0 / 12.0 : (1.0 - half / std::tan(half)) / (angle * angle);
  Vector6 xi;
  xi << t - 0.5 * w.cross(t) + c * w.cross(w.cross(t)), w;
  return xi;
}

LoopCheckResult CheckLoop(const LoopScan& a, const LoopScan& b, std::span<const Pose> T_a_b_starts,
                          const std::optional<LoopEstimate>& estimate, const LoopCheckParams& params) {
  std::vector<LoopCheckResult> found;
  if (estimate) found.push_back(CheckFrom(a, b, estimate->T_a_b, estimate, params));
  for (const Pose& start : T_a_b_starts) found.push_back(CheckFrom(a, b, start, estimate, params));
  if (found.empty()) return {};
  std::stable_sort(found.begin(), found.end(), [](const LoopCheckResult& x, const LoopCheckResult& y) {
    return x.accepted() != y.accepted() ? x.accepted() : x.agreement > y.agreement;
  });
  LoopCheckResult best = found.front();
  if (!best.accepted()) return best;
  for (const LoopCheckResult& other : found) {
    if (other.accepted() && !Same(best.T_a_b, other.T_a_b, params) &&
        other.agreement > best.agreement - params.ambiguity_margin) {
      best.verdict = LoopVerdict::kAmbiguous;
      return best;
    }
  }
  best.information = InformationOf(best.registration, params.floor_m, params.floor_deg);
  return best;
}

}  // namespace atlas::mapping
