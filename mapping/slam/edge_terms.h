// What an edge contributes to normal equations: its error by each convention of cost (pose_graph.h), and how
// that moves with right perturbations of its two nodes.
#pragma once

#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

template <int kRows>
struct EdgeTerms {
  Eigen::Matrix<double, kRows, 1> error;
  Eigen::Matrix<double, kRows, 6> by_from, by_to;
};

/// Log(E), E = T_from_to^-1 T_map_from^-1 T_map_to.
EdgeTerms<6> LogMapTerms(const PoseEdge& edge, const core::Pose& T_map_from, const core::Pose& T_map_to);
/// (t, vec q) of E, with q.w >= 0; in the plane (t, yaw).
EdgeTerms<6> G2oTerms(const PoseEdge& edge, const core::Pose& T_map_from, const core::Pose& T_map_to,
                      bool planar);
/// sqrt(kappa) times the columns of R_to - R_from R, then sqrt(tau) (t_to - t_from - R_from t).
EdgeTerms<12> ChordalTerms(const PoseEdge& edge, const core::Pose& T_map_from, const core::Pose& T_map_to,
                           const ChordalWeights& weights);

}  // namespace atlas::mapping
