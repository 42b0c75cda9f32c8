// Whether two keyframes that look alike are one place: registration from each way in which they may lie, and
// the evidence against it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry.h"
#include "mapping/cloud/registration.h"
#include "mapping/cloud/surface_cloud.h"

namespace atlas::mapping {

/// What a keyframe saw in each direction from its origin: a point nearer than that lies where its beams
/// passed.
class RangeView {
 public:
  enum class Sight { kUnknown, kInFront, kAtSurface, kHidden };

  /// @param p_here undistorted returns in the frame of the sensor.
  explicit RangeView(std::span<const core::Vec3f> p_here);
  /// Of what nearest() and farthest() told. @pre kCells each
  RangeView(std::vector<uint16_t> nearest, std::vector<uint16_t> farthest)
      : nearest_(std::move(nearest)), farthest_(std::move(farthest)) {}
  /// Of a point: in front of all that was seen about its direction by more than `margin_m`, behind all of it,
  /// or neither; unknown where nothing was seen.
  Sight Of(const core::Vec3f& p_here, float margin_m) const;

  static constexpr int kColumns = 360, kRows = 90;  ///< a degree by two
  static constexpr size_t kCells = static_cast<size_t>(kColumns) * kRows;
  const std::vector<uint16_t>& nearest() const { return nearest_; }
  const std::vector<uint16_t>& farthest() const { return farthest_; }

 private:
  static constexpr float kUnit_m = 0.005f;  ///< of what is kept: a graph has a view a node
  static size_t CellOf(const core::Vec3f& p, float range_m);
  std::vector<uint16_t> nearest_, farthest_;  ///< of a cell and those around it, in units; 0: nothing seen
};

/// A keyframe prepared for being compared. May be moved.
struct LoopScan {
  SurfaceCloud cloud;
  RangeView view;
};
/// @param p_here undistorted returns of one revolution in the keyframe's frame, the sensor at or near its
/// origin.
LoopScan PrepareLoopScan(std::span<const core::Vec3f> p_here, const SurfaceCloudParams& params);

struct LoopCheckParams {
  RegistrationParams registration;
  double min_overlap =
      0.6;  ///< share of what either could see of the other's points that lies beside its own
  double min_agreement = 0.5;  ///< share of it on the other's surface: to a quarter of a voxel, facing alike
  double min_shared = 0.25;    ///< share of all points, hidden ones included, beside the other's
  double max_rmse_voxels = 0.5;  ///< of the inliers' distances
  /// Share of points where the other's beams passed. Over keyframes of rooms and campus at most 0.005 where
  /// the result is right; 95 % of the wrong ones in rooms exceed 0.009, down to which moving things allow it.
  double max_in_front = 0.01;
  double ambiguity_margin = 0.15;  ///< another way whose agreement comes so near is as good
  double same_m = 0.3;             ///< two results as near as this, and same_deg, are one
  double same_deg = 5.0;
  double max_gate_sq =
      22.46;               ///< squared Mahalanobis distance from the estimate: 99.9 % of 6 degrees of freedom
  double floor_m = 0.005;  ///< least standard deviations: of what neither noise nor Hessian knows
  double floor_deg = 0.05;
};

/// What the graph knows of the two keyframes.
struct LoopEstimate {
  core::Pose T_a_b = core::Pose::Identity();
  Matrix6 covariance = Matrix6::Identity();  ///< of xi in T_a_b Exp(xi)
};

enum class LoopVerdict {
  kAccepted,
  kNotConverged,
  kDegenerate,
  kRmse,
  kOverlap,
  kInFront,
  kGate,
  kAmbiguous
};
/// "accepted", "not converged", ...
std::string_view NameOf(LoopVerdict verdict);

struct LoopCheckResult {
  LoopVerdict verdict = LoopVerdict::kNotConverged;
  core::Pose T_a_b = core::Pose::Identity();  ///< the best found, whatever the verdict
  /// Inverse covariance of T_a_b Exp(xi), translation before rotation. Zero unless accepted.
  Matrix6 information = Matrix6::Zero();
  double overlap = 0.0, agreement = 0.0;  ///< the lesser of both directions
  double in_front = 0.0;                  ///< the greater of both directions
  RegistrationResult registration;

  bool accepted() const { return verdict == LoopVerdict::kAccepted; }
};

/// Registers `b` to `a` from each of `T_a_b_starts` (of place recognition) and from the estimate, where there
/// is one, and judges the results. Results outside the estimate's gate are refused; with two left that pass
/// and part, the loop is refused as ambiguous.
LoopCheckResult CheckLoop(const LoopScan& a, const LoopScan& b, std::span<const core::Pose> T_a_b_starts,
                          const std::optional<LoopEstimate>& estimate, const LoopCheckParams& params);

/// xi for which T Exp(xi) is `other`: translation before rotation.
Vector6 Difference(const core::Pose& T, const core::Pose& other);

/// Inverse covariance of a registration: its Hessian over twice the variance of the distances (voxels' means
/// and normals are shared by neighbours: over simulated pairs in rooms and on campus the squared error then
/// is 0.2 to 0.9 of what it predicts), and the floors.
Matrix6 InformationOf(const RegistrationResult& registration, double floor_m, double floor_deg);

}  // namespace atlas::mapping
