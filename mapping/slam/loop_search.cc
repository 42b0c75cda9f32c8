#include "mapping/slam/loop_search.h"

#include <algorithm>
#include <cmath>

#include "mapping/cloud/registration.h"
#include "mapping/slam/graph_covariance.h"

namespace atlas::mapping {
namespace {

using core::Mat6;
using core::Pose;
using core::Vec6;

constexpr double kGateSigmas = 3.0;
constexpr double kWidestGateM = 10.0;

/// Metres along odometry from each node to the latest.
std::vector<double> WaysToLatest(const std::vector<Pose>& T_map_node) {
  std::vector<double> way(T_map_node.size(), 0.0);
  for (size_t i = T_map_node.size() - 1; i-- > 0;) {
    way[i] = way[i + 1] + (T_map_node[i + 1].translation() - T_map_node[i].translation()).norm();
  }
  return way;
}

}  // namespace

std::vector<LoopSearch::Candidate> LoopSearch::Near(const PoseGraph& inliers) const {
  const uint32_t latest = inliers.size() - 1;
  const std::vector<double> way_m = WaysToLatest(inliers.T_map_node);
  const auto covariance = GraphCovariance::Of(inliers);
  std::vector<Candidate> near;
  for (uint32_t node = 0; node < latest; ++node) {
    if (way_m[node] < params_.loop_min_way_m) continue;
    const double distance_m =
        (inliers.T_map_node[node].translation() - inliers.T_map_node[latest].translation()).norm();
    if (distance_m > params_.loop_radius_m + kWidestGateM) continue;
    double gate_m = 0.0;
    if (covariance && distance_m > params_.loop_radius_m)
      gate_m = kGateSigmas * GreatestTranslationSigma(covariance->Relative(node, latest));
    if (distance_m <= params_.loop_radius_m + std::min(gate_m, kWidestGateM))
      near.push_back({node, distance_m});
  }
  std::sort(near.begin(), near.end(), [](const Candidate& a, const Candidate& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.node < b.node;
  });
  return near;
}

std::optional<Loop> LoopSearch::Verify(uint32_t older, const PoseGraph& inliers) const {
  const uint32_t latest = inliers.size() - 1;
  const SurfaceCloud &target = clouds_[older], &source = clouds_[latest];
  const Pose start = inliers.T_map_node[older].inverse() * inliers.T_map_node[latest];
  const RegistrationResult fit = Register(target, source, start, {});
  if (!fit.converged || fit.degenerate || fit.overlap < params_.loop_overlap) return std::nullopt;
  if (fit.inlier_rmse_m > 0.5 * target.voxel_m()) return std::nullopt;
  return Loop{older, latest, fit.T_target_source};
}

std::vector<Loop> LoopSearch::FromLatest(const PoseGraph& inliers) const {
  std::vector<Loop> loops;
  int tries = 0;
  for (const Candidate& candidate : Near(inliers)) {
    if (tries++ == params_.loop_tries) break;
    if (const auto loop = Verify(candidate.node, inliers)) loops.push_back(*loop);
  }
  return loops;
}

}  // namespace atlas::mapping
