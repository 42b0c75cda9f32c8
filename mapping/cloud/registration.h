// Generalised ICP (Segal et al. 2009) of two clouds, plane to plane, from far starts; and what its result is
// worth.
#pragma once

#include <Eigen/Dense>

#include "core/geometry.h"
#include "mapping/cloud/surface_cloud.h"

namespace atlas::mapping {

/// Tangent order: translation, then rotation; right perturbation T Exp(xi).
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// T Exp(xi).
core::Pose Perturbed(const core::Pose& T, const Vector6& xi);

struct RegistrationParams {
  /// Of the first pairs; it shrinks to two voxels as they agree.
  double max_distance_m = 3.0;
  int max_iterations = 60;
  double converged_m = 1e-4;  ///< a step below this, and below converged_rad, ends the search
  double converged_rad = 1e-4;
  /// Pairs whose normals part by more than 90 degrees are the two sides of a wall. Off for clouds that were
  /// seen from many places, whose normals face nowhere.
  bool facing = true;
  /// Below this eigenvalue of the scatter of the pairs' normals (a third each for a cube) the pairs say
  /// nothing about the translation along its eigenvector. Bare corridors come to 0.01 by normals at
  /// their edges, rooms and streets to 0.07 and more.
  double min_eigenvalue = 0.02;
  int threads = 1;  ///< results do not depend on it
};

struct RegistrationResult {
  core::Pose T_target_source = core::Pose::Identity();
  bool converged = false;
  int iterations = 0;
  size_t inliers = 0;          ///< pairs within two voxels, both with a normal
  double overlap = 0.0;        ///< share of the source's points within two voxels of the target's
  double inlier_rmse_m = 0.0;  ///< of the pairs' distances along the target's normals
  /// Gauss-Newton's J^T J of those distances (metres, unweighted): divided by their variance it is the
  /// information, were they independent.
  Matrix6 hessian = Matrix6::Zero();
  /// Of the scatter of the pairs' normals, which is the Hessian's translation block per inlier without the
  /// normals' noise: 0 on a plane, up to 1/3.
  double min_eigenvalue = 0.0;
  core::Vec3 weak_direction_target = core::Vec3::Zero();  ///< its eigenvector, unit
  bool degenerate = true;                                 ///< min_eigenvalue below the limit, or no pairs
};

/// Aligns the source to the target. The same bytes for any number of threads.
RegistrationResult Register(const SurfaceCloud& target, const SurfaceCloud& source,
                            const core::Pose& T_target_source_start, const RegistrationParams& params);

}  // namespace atlas::mapping
