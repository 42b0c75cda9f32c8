// `localisation.name: slam`. A keyframe is a node of a pose graph: the base, wherever odometry had gone
// node_spacing from the node before. Its first revolution is its cloud; where that fits an older node's, a
// loop closes and all keyframes move (thesis 4.4.1, 4.7).
#include <utility>

#include "mapping/cloud/undistort.h"
#include "mapping/slam/builders.h"
#include "mapping/slam/graph_poses.h"
#include "mapping/slam/loop_search.h"
#include "mapping/slam/pose_graph_slam.h"

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
  v.Field("loop_sigma_m", &loop_sigma_m,
          {.unit = "m", .min = 1e-4, .max = 1.0, .doc = "slam: a registration's error (each axis)"});
  v.Field("loop_sigma_deg", &loop_sigma_deg,
          {.unit = "deg", .min = 1e-3, .max = 10.0, .doc = "slam: likewise of its rotation"});
  v.Field("loop_radius_m", &loop_radius_m,
          {.unit = "m", .min = 0.5, .max = 50.0, .doc = "slam: nodes this near are tried for a loop"});
  v.Field("loop_min_way_m", &loop_min_way_m,
          {.unit = "m", .min = 1.0, .max = 1000.0, .doc = "slam: but only after such a way"});
  v.Field("loop_overlap", &loop_overlap,
          {.min = 0.1, .max = 1.0, .doc = "slam: least overlap of a loop's clouds"});
  v.Field("loop_tries", &loop_tries, {.min = 0, .max = 20, .doc = "slam: registrations a node; 0: no loops"});
}

namespace {

using core::Mat6;
using core::Pose;

constexpr double kEdgeM = 2.0;  ///< that the sigmas of odometry are of

Mat6 InformationOf(double sigma_m, double sigma_rad) {
  Mat6 information = Mat6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (sigma_m * sigma_m));
  information.diagonal().tail<3>().setConstant(1.0 / (sigma_rad * sigma_rad));
  return information;
}

class SlamLocaliser final : public Localiser {
 public:
  SlamLocaliser(const SlamParams& params, const LocaliserStart& start)
      : params_(params),
        edge_covariance_(start.edge_covariance),
        graph_(start.T_map_odom * start.T_odom_base),
        search_(params),
        T_odom_node_(start.T_odom_base),
        T_odom_base_(start.T_odom_base) {}

  void OnState(const core::StateEvent& state) override { T_odom_base_ = state.T_odom_base; }

  core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) override {
    if ((T_odom_base_.translation() - T_odom_node_.translation()).norm() >= params_.node_spacing_m)
      BeginNode();
    if (!std::exchange(seen_, true)) CloseLoops(*spin);
    return {std::move(spin), latest(), T_odom_node_.inverse()};
  }

  std::optional<PoseGraph> InlierGraph() const override { return graph_.InlierGraph(); }
  Pose T_map_odom() const override { return graph_.T_map_node().back() * T_odom_node_.inverse(); }

  std::shared_ptr<const core::PoseSource> poses() const override {
    if (!snapshot_) snapshot_ = std::make_shared<const GraphPoses>(graph_.T_map_node(), graph_.version());
    return snapshot_;
  }

 private:
  core::KeyframeId latest() const { return static_cast<core::KeyframeId>(graph_.T_map_node().size() - 1); }

  void BeginNode() {
    const Pose T_latest_node = T_odom_node_.inverse() * T_odom_base_;
    const double way_m = T_latest_node.translation().norm(), share = std::sqrt(way_m / kEdgeM);
    graph_.AddNode(T_latest_node, edge_covariance_
                                      ? Mat6(edge_covariance_(way_m).inverse())
                                      : InformationOf(share * params_.odometry_sigma_m,
                                                      share * core::Radians(params_.odometry_sigma_deg)));
    T_odom_node_ = T_odom_base_;
    seen_ = false;
    snapshot_.reset();
  }

  /// With the first revolution of a node.
  void CloseLoops(const core::SpinEvent& spin) {
    UndistortHits(spin, T_odom_node_.inverse(), &rays_);
    std::vector<core::Vec3f> cloud;
    for (const MapRay& hit : rays_.hits) cloud.push_back(hit.origin_map + hit.range_m * hit.direction_map);
    SurfaceCloudParams surface;
    if (!rays_.hits.empty()) surface.viewpoint = rays_.hits.front().origin_map;
    search_.AddCloud(SurfaceCloud(cloud, surface));
    if (params_.loop_tries == 0) return;
    const std::vector<Loop> loops = search_.FromLatest(graph_.InlierGraph());
    for (const Loop& loop : loops) {
      graph_.AddLoop(loop.from, loop.to, loop.T_from_to,
                     InformationOf(params_.loop_sigma_m, core::Radians(params_.loop_sigma_deg)));
    }
    if (loops.empty()) return;
    graph_.Resolve();
    snapshot_.reset();
  }

  SlamParams params_;
  std::function<Mat6(double)> edge_covariance_;
  PoseGraphSlam graph_;
  LoopSearch search_;
  Pose T_odom_node_;  ///< of the latest node
  Pose T_odom_base_;
  bool seen_ = false;  ///< the latest node has its cloud
  UndistortedSpin rays_;
  mutable std::shared_ptr<const GraphPoses> snapshot_;
};

}  // namespace

std::unique_ptr<Localiser> BuildSlamLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                              const core::Rng&) {
  return std::make_unique<SlamLocaliser>(params.slam, start);
}

}  // namespace atlas::mapping
