// `localisation.name: slam`, the front end (thesis Fig. 4.6). A keyframe is a node of a pose graph: the base,
// wherever odometry had gone node_spacing from the node before. When the next one begins, the back end is
// handed what the node saw; where that fits an older node's cloud, a loop closes and all keyframes move
// (thesis 4.4.1, 4.7), `latency_s` of simulated time later, whatever the machine and the number of threads:
//
//     node k ends ──────── latency_s ───────> its loops take effect ──> ... full_latency_s: a full robust
//     pass
//        └ back end: loops, warm solve ┘          (waits for the back end where that is late)
#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "core/task_lanes.h"

#include "mapping/cloud/undistort.h"
#include "mapping/slam/back_end.h"
#include "mapping/slam/builders.h"
#include "mapping/slam/graph_poses.h"

namespace atlas::mapping {

void SlamParams::Visit(core::ParamVisitor& v) {
  v.Field("node_spacing_m", &node_spacing_m,
          {.unit = "m", .min = 0.2, .max = 20.0, .doc = "slam: from node to node (thesis 4.10.1)"});
  v.Field("odometry_sigma_m", &odometry_sigma_m,
          {.unit = "m",
           .min = 1e-4,
           .max = 1.0,
           .doc = "slam: odometry's error after 2 m (standard deviation of each axis)"});
  v.Field("odometry_sigma_deg", &odometry_sigma_deg,
          {.unit = "deg", .min = 1e-3, .max = 10.0, .doc = "slam: likewise of its rotation"});
  v.Field("loop_radius_m", &loop_radius_m,
          {.unit = "m", .min = 0.5, .max = 50.0, .doc = "slam: nodes this near are tried for a loop"});
  v.Field("loop_min_way_m", &loop_min_way_m,
          {.unit = "m", .min = 1.0, .max = 1000.0, .doc = "slam: but only after such a way"});
  v.Field("loop_overlap", &loop_overlap,
          {.min = 0.1, .max = 1.0, .doc = "slam: least overlap of a loop's clouds"});
  v.Field("loop_gate_sigmas", &loop_gate_sigmas,
          {.min = 1.0,
           .max = 100.0,
           .doc = "slam: a loop may move its node by so many of the graph's standard deviations"});
  v.Field("loop_tries", &loop_tries,
          {.min = 0,
           .max = 20,
           .doc = "slam: registrations a node, of those near it and of those that look alike; 0: no loops"});
  v.Field(
      "place_distance", &place_distance,
      {.min = 0.0, .max = 1.0, .doc = "slam: between plans that may be one place; 0: no place recognition"});
  v.Field("latency_s", &latency_s,
          {.unit = "s",
           .min = 0.0,
           .max = 60.0,
           .doc = "slam: simulated time from a node's end until its loops take effect"});
  v.Field(
      "full_latency_s", &full_latency_s,
      {.unit = "s", .min = 0.0, .max = 600.0, .doc = "slam: likewise of the full robust pass after loops"});
}

namespace {

using core::Mat6;
using core::Pose;

constexpr double kEdgeM = 2.0;  ///< that the sigmas of odometry are of
/// A node's cloud takes another revolution after the sensor has moved so far: sixteen rows alone say little
/// of the height.
constexpr double kLookAgainM = 0.25, kLookAgainDeg = 1.5;
constexpr int kMostLooks = 24;

bool HasMoved(const Pose& T, const Pose& to) {
  const Pose between = T.inverse() * to;
  return between.translation().norm() > kLookAgainM ||
         Eigen::AngleAxisd(between.linear()).angle() > core::Radians(kLookAgainDeg);
}

Mat6 InformationOf(double sigma_m, double sigma_rad) {
  Mat6 information = Mat6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (sigma_m * sigma_m));
  information.diagonal().tail<3>().setConstant(1.0 / (sigma_rad * sigma_rad));
  return information;
}

/// Where nodes lie, from some moment of simulated time on.
struct Correction {
  double effective_s = 0.0;
  core::TaskLanes::Ticket ticket = 0;
  std::shared_ptr<SolvedNodes> nodes;  ///< written by the ticket's task
};

class SlamLocaliser final : public Localiser {
 public:
  SlamLocaliser(const SlamParams& params, const LocaliserStart& start)
      : params_(params),
        edge_covariance_(start.edge_covariance),
        back_end_(params, start.T_map_odom * start.T_odom_base, start.earlier),
        T_map_node_(start.earlier ? start.earlier->graph.T_map_node : std::vector<Pose>{}),
        begin_(T_map_node_.size()),
        located_(!start.earlier),
        T_odom_node_(start.T_odom_base),
        T_odom_base_(start.T_odom_base),
        lane_(1, start.threads > 1) {
    T_map_node_.push_back(start.T_map_odom * start.T_odom_base);
    steps_.resize(T_map_node_.size());
    solved_ = std::make_shared<const SolvedGraph>(std::make_shared<const PoseGraph>(
        start.earlier ? start.earlier->graph : PoseGraph{.T_map_node = T_map_node_}));
  }

  void OnState(const core::StateEvent& state) override {
    now_s_ = state.time_s;
    T_odom_base_ = state.T_odom_base;
    while (!under_way_.empty() && under_way_.front().effective_s <= now_s_) TakeEffect();
  }

  core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) override {
    if ((T_odom_base_.translation() - T_odom_node_.translation()).norm() >= params_.node_spacing_m)
      BeginNode();
    if (params_.loop_tries > 0) Look(*spin);
    return {std::move(spin), latest(), T_odom_node_.inverse()};
  }

  Pose T_map_odom() const override { return T_map_node_.back() * T_odom_node_.inverse(); }

  std::optional<PoseGraph> InlierGraph() const override {
    PoseGraph graph = solved_->inliers();
    for (uint32_t node = graph.size(); node < T_map_node_.size(); ++node) {
      if (node == begin_) continue;  // the first of a session: no edge leads to it
      graph.edges.push_back(
          {node - 1, node, steps_[node].T_previous_node, steps_[node].covariance.inverse()});
    }
    graph.T_map_node = T_map_node_;
    return graph;
  }

  std::shared_ptr<const core::PoseSource> poses() const override {
    if (!snapshot_) snapshot_ = std::make_shared<const GraphPoses>(T_map_node_, version_, solved_, steps_);
    return snapshot_;
  }

  bool located() const override { return located_; }
  std::shared_ptr<const SlamMemory> Memory() const override {
    return std::make_shared<const SlamMemory>(back_end_.Memory());
  }

  void Settle() override {
    Finish();
    while (!under_way_.empty()) TakeEffect();
  }

 private:
  core::KeyframeId latest() const { return static_cast<core::KeyframeId>(T_map_node_.size() - 1); }

  void BeginNode() {
    Finish();
    const Pose T_previous_node = T_odom_node_.inverse() * T_odom_base_;
    node_ = {T_previous_node, InformationOfEdge(T_previous_node.translation().norm()), {}};
    T_map_node_.push_back(T_map_node_.back() * T_previous_node);
    steps_.push_back({T_previous_node, node_.information.inverse()});
    T_odom_node_ = T_odom_base_;
    looked_from_.reset();
    looks_ = 0;
    snapshot_.reset();
  }

  Mat6 InformationOfEdge(double way_m) const {
    if (edge_covariance_) return edge_covariance_(way_m).inverse();
    const double share = std::sqrt(way_m / kEdgeM);
    return InformationOf(share * params_.odometry_sigma_m, share * core::Radians(params_.odometry_sigma_deg));
  }

  /// Gathers what the node sees: its first revolution, and others from where the sensor has moved since.
  void Look(const core::SpinEvent& spin) {
    const Pose T_odom_lidar = spin.T_odom_lidar.poses().front().T;
    const bool first = !looked_from_;
    if (!first && (looks_ == kMostLooks || !HasMoved(*looked_from_, T_odom_lidar))) return;
    looked_from_ = T_odom_lidar;
    ++looks_;
    if (first) node_.cloud.T_node_lidar = T_odom_node_.inverse() * T_odom_lidar;
    UndistortHits(spin, (T_odom_node_ * node_.cloud.T_node_lidar).inverse(), &rays_);
    std::vector<core::Vec3f>& cloud = first ? node_.cloud.first_lidar : node_.cloud.later_lidar;
    for (const MapRay& hit : rays_.hits) cloud.push_back(hit.origin_map + hit.range_m * hit.direction_map);
  }

  /// Hands the latest node to the back end.
  void Finish() {
    if (!looked_from_) return;
    Post(params_.latency_s, [this, node = std::make_shared<const FinishedNode>(std::exchange(node_, {}))] {
      return back_end_.Take(*node);
    });
  }

  /// The back end does one thing after the other.
  void Post(double latency_s, std::function<SolvedNodes()> work) {
    busy_until_s_ = std::max(now_s_, busy_until_s_) + latency_s;
    Correction correction{busy_until_s_, 0, std::make_shared<SolvedNodes>()};
    correction.ticket =
        lane_.Post(0, [nodes = correction.nodes, work = std::move(work)] { *nodes = work(); });
    under_way_.push_back(std::move(correction));
  }

  void TakeEffect() {
    const Correction correction = std::move(under_way_.front());
    under_way_.pop_front();
    lane_.Wait(0, correction.ticket);
    const SolvedNodes& solved = *correction.nodes;
    if (solved.full_pass_due && under_way_.empty())
      Post(params_.full_latency_s, [this] { return back_end_.FullPass(); });
    located_ = solved.located;
    if (std::exchange(version_, solved.version) == solved.version) return;
    std::copy(solved.T_map_node.begin(), solved.T_map_node.end(), T_map_node_.begin());
    for (size_t node = solved.T_map_node.size(); node < T_map_node_.size(); ++node)
      T_map_node_[node] = T_map_node_[node - 1] * steps_[node].T_previous_node;
    solved_ = std::make_shared<const SolvedGraph>(solved.inliers);
    snapshot_.reset();
  }

  SlamParams params_;
  std::function<Mat6(double)> edge_covariance_;
  SlamBackEnd back_end_;  ///< touched by tasks of the lane alone
  std::vector<Pose> T_map_node_;
  size_t begin_;  ///< the session's first node
  bool located_;
  std::shared_ptr<const SolvedGraph> solved_;  ///< as of version_
  std::vector<NodeStep> steps_;                ///< by odometry
  uint64_t version_ = 0;
  Pose T_odom_node_;  ///< of the latest node
  Pose T_odom_base_;
  double now_s_ = 0.0, busy_until_s_ = 0.0;  ///< of the back end, as simulated
  FinishedNode node_;                        ///< the latest one, in the making
  std::optional<Pose> looked_from_;          ///< T_odom_lidar of the latest revolution in its cloud
  int looks_ = 0;                            ///< revolutions in it
  UndistortedSpin rays_;
  std::deque<Correction> under_way_;  ///< in the order in which they take effect
  mutable std::shared_ptr<const GraphPoses> snapshot_;
  core::TaskLanes lane_;  ///< ends before what its tasks touch
};

}  // namespace

std::unique_ptr<Localiser> BuildSlamLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                              const core::Rng&) {
  return std::make_unique<SlamLocaliser>(params.slam, start);
}

}  // namespace atlas::mapping
