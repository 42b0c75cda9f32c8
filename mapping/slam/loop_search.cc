#include "mapping/slam/loop_search.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "mapping/slam/graph_covariance.h"

namespace atlas::mapping {
namespace {

using core::Mat6;
using core::Pose;
using core::Vec3f;

constexpr double kWidestGateM = 10.0;
/// A corridor with doors has 0.005 to 0.02 along it; its loops are weighed by their Hessian, so that what is
/// weak counts little. Below: a bare one.
constexpr double kLeastEigenvalue = 0.004;
/// Of estimates, however sure the graph is: registrations are no better.
constexpr double kFloorM = 0.02, kFloorDeg = 0.3;

/// The rotation without its yaw: what turns the sensor level.
core::Mat3 Levelled(const core::Mat3& R_map_lidar) {
  return core::RotationFromYawPitchRoll(-std::atan2(R_map_lidar(1, 0), R_map_lidar(0, 0)), 0.0, 0.0) *
         R_map_lidar;
}

}  // namespace

void LoopSearch::Add(const NodeCloud& cloud, const Pose& T_map_node) {
  std::vector<Vec3f> all = cloud.first_lidar;
  all.insert(all.end(), cloud.later_lidar.begin(), cloud.later_lidar.end());
  const core::Mat3 R_level_lidar = Levelled((T_map_node * cloud.T_node_lidar).linear());
  std::vector<Vec3f> level;
  level.reserve(all.size());
  for (const Vec3f& p : all) level.push_back(R_level_lidar.cast<float>() * p);
  latest_place_ = DescribePlace(level);
  places_.Add(static_cast<uint32_t>(views_.size()), latest_place_);
  views_.push_back(
      {{SurfaceCloud(all, {}), RangeView(cloud.first_lidar)}, cloud.T_node_lidar, R_level_lidar});
}

void LoopSearch::Recall(const NodeMemory& node, const Pose& T_map_node) {
  assert(views_.size() == recalled_);
  ++recalled_;
  places_.Add(static_cast<uint32_t>(views_.size()), DescribePlan(node.plan));
  SurfaceCloudParams as_it_was;
  as_it_was.voxel_m = node.voxel_m;
  views_.push_back({{SurfaceCloud(node.points_lidar, as_it_was), RangeView(node.nearest, node.farthest)},
                    node.T_node_lidar,
                    Levelled((T_map_node * node.T_node_lidar).linear())});
}

std::vector<NodeMemory> LoopSearch::Memory() const {
  std::vector<NodeMemory> memory;
  for (size_t node = 0; node < views_.size(); ++node) {
    const LoopScan& scan = views_[node].scan;
    memory.push_back({views_[node].T_node_lidar, scan.cloud.voxel_m(), scan.cloud.points(),
                      scan.view.nearest(), scan.view.farthest(), places_.place(node).cells});
  }
  return memory;
}

std::vector<double> LoopSearch::WaysToLatest(const std::vector<Pose>& T_map_node) const {
  std::vector<double> way(T_map_node.size(), 0.0);
  for (size_t i = T_map_node.size() - 1; i-- > 0;) {
    way[i] = i + 1 == recalled_
                 ? std::numeric_limits<double>::infinity()
                 : way[i + 1] + (T_map_node[i + 1].translation() - T_map_node[i].translation()).norm();
  }
  return way;
}

std::vector<LoopSearch::Candidate> LoopSearch::Near(const PoseGraph& inliers,
                                                    const std::vector<double>& way_m) const {
  const uint32_t latest = inliers.size() - 1;
  const auto covariance = GraphCovariance::Of(inliers);
  std::vector<Candidate> near;
  for (uint32_t node = 0; node < latest; ++node) {
    if (way_m[node] < params_.loop_min_way_m) continue;
    const double distance_m =
        (inliers.T_map_node[node].translation() - inliers.T_map_node[latest].translation()).norm();
    if (distance_m > params_.loop_radius_m + kWidestGateM) continue;
    std::optional<Mat6> relative;
    if (covariance) relative = covariance->Relative(node, latest);
    const double gate_m = relative ? params_.loop_gate_sigmas * GreatestTranslationSigma(*relative) : 0.0;
    if (distance_m <= params_.loop_radius_m + std::min(gate_m, kWidestGateM))
      near.push_back({node, distance_m, relative, {}});
  }
  std::sort(near.begin(), near.end(), [](const Candidate& a, const Candidate& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.node < b.node;
  });
  return near;
}

std::vector<LoopSearch::Candidate> LoopSearch::Alike(const std::vector<double>& way_m) const {
  PlaceQueryParams query;
  query.max_distance = params_.place_distance;
  query.skip_youngest = static_cast<size_t>(
      std::count_if(way_m.begin(), way_m.end(), [&](double way) { return way < params_.loop_min_way_m; }));
  std::vector<Candidate> alike;
  for (const PlaceCandidate& place : places_.Query(latest_place_, query)) {
    const auto known = std::find_if(alike.begin(), alike.end(),
                                    [&](const Candidate& candidate) { return candidate.node == place.id; });
    Candidate& candidate =
        known != alike.end() ? *known : alike.emplace_back(Candidate{place.id, 0.0, std::nullopt, {}});
    const auto level = [&](const View& view) {
      return core::MakePose(view.R_level_lidar, core::Vec3::Zero());
    };
    candidate.T_lidar_latest_starts.push_back(level(views_[place.id]).inverse() * place.T_candidate_query *
                                              level(views_.back()));
  }
  return alike;
}

std::optional<Loop> LoopSearch::Verify(const Candidate& candidate, const PoseGraph& inliers) const {
  const uint32_t latest = inliers.size() - 1, older = candidate.node;
  const View &a = views_[older], &b = views_[latest];
  const Pose T_a_b =
      (inliers.T_map_node[older] * a.T_node_lidar).inverse() * (inliers.T_map_node[latest] * b.T_node_lidar);
  // A perturbation of the latest node, as its sensor has it.
  const Mat6 to_lidar = core::Adjoint(b.T_node_lidar.inverse());
  LoopCheckParams check;
  check.min_overlap = params_.loop_overlap;
  check.registration.min_eigenvalue = kLeastEigenvalue;
  check.max_gate_sq *= params_.loop_gate_sigmas * params_.loop_gate_sigmas / 9.0;
  std::optional<LoopEstimate> estimate;
  std::vector<Pose> starts = candidate.T_lidar_latest_starts;
  if (candidate.covariance) {
    estimate = LoopEstimate{T_a_b, to_lidar * *candidate.covariance * to_lidar.transpose()};
    estimate->covariance.diagonal().head<3>().array() += kFloorM * kFloorM;
    estimate->covariance.diagonal().tail<3>().array() += core::Radians(kFloorDeg) * core::Radians(kFloorDeg);
  } else if (starts.empty()) {
    starts = {T_a_b};
  }
  const LoopCheckResult result = CheckLoop(a.scan, b.scan, starts, estimate, check);
  if (!result.accepted()) return std::nullopt;
  return Loop{older, latest, a.T_node_lidar * result.T_a_b * b.T_node_lidar.inverse(),
              to_lidar.transpose() * result.information * to_lidar};
}

std::vector<Loop> LoopSearch::FromLatest(const PoseGraph& inliers) const {
  const std::vector<double> way_m = WaysToLatest(inliers.T_map_node);
  const auto tries = static_cast<size_t>(params_.loop_tries);
  std::vector<Candidate> near = Near(inliers, way_m), alike = Alike(way_m), tried;
  for (size_t k = 0; k < std::min(tries, near.size()); ++k) tried.push_back(near[k]);
  for (size_t k = 0; k < std::min(tries, alike.size()); ++k) {
    const auto same = [&](const Candidate& candidate) { return candidate.node == alike[k].node; };
    if (std::any_of(tried.begin(), tried.end(), same)) continue;
    const auto known = std::find_if(near.begin(), near.end(), same);
    if (known != near.end()) alike[k].covariance = known->covariance;
    tried.push_back(alike[k]);
  }
  std::vector<Loop> loops;
  for (const Candidate& candidate : tried) {
    if (const auto loop = Verify(candidate, inliers)) loops.push_back(*loop);
  }
  return loops;
}

std::vector<Loop> LoopSearch::ToRecalled(const PoseGraph& graph) const {
  std::vector<Candidate> alike = Alike(WaysToLatest(graph.T_map_node));
  std::erase_if(alike, [&](const Candidate& candidate) { return candidate.node >= recalled_; });
  std::vector<Loop> loops;
  for (size_t k = 0; k < std::min(alike.size(), static_cast<size_t>(params_.loop_tries)); ++k) {
    if (const auto loop = Verify(alike[k], graph)) loops.push_back(*loop);
  }
  return loops;
}

}  // namespace atlas::mapping
