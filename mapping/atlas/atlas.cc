#include "mapping/atlas/atlas.h"

#include <algorithm>
#include <limits>

#include "mapping/cloud/undistort.h"
#include "mapping/integrator/occupancy_states.h"

namespace atlas::mapping {
namespace {

using core::Box3;
using core::KeyframeId;
using core::Pose;
using core::Vec3;
using core::Vec3f;

/// What is kept of a submap reaches this far past the box in the map frame, so that a correction brings in
/// what lay just outside.
constexpr double kKeepMarginM = 1.0;

Box3 Everywhere() {
  return TraceLimits{}.box_map;
}

std::vector<Vec3f> PointsOf(const UndistortedSpin& rays) {
  std::vector<Vec3f> points;
  for (const MapRay& hit : rays.hits) points.push_back(hit.origin_map + hit.range_m * hit.direction_map);
  return points;
}

}  // namespace

void AtlasParams::Visit(core::ParamVisitor& v) {
  v.Field("lambda_odom_m", &lambda_odom_m,
          {.unit = "m",
           .min = 1.0,
           .max = 1e6,
           .doc = "a submap ends this far along the keyframes from its root (thesis 4.7.1)"});
  v.Field("cloud_overlap", &cloud_overlap,
          {.min = 0.0,
           .max = 1.0,
           .doc = "a submap ends where less of a keyframe's cloud overlaps its own (thesis 4.7.3)"});
  v.Field("cloud_filter_m", &cloud_filter_m,
          {.unit = "m", .min = 0.02, .max = 2.0, .doc = "r_filter of cloud overlap (thesis Alg. 1)"});
}

Atlas::Atlas(const AtlasParams& params, const AtlasSetup& setup) : params_(params), setup_(setup) {}
Atlas::~Atlas() = default;

OctreeContents Atlas::Empty() const {
  OctreeContents contents{OccupancyOctree(setup_.resolution_m), {}};
  if (setup_.map.behind_surface) contents.behind.emplace(setup_.resolution_m, setup_.behind_surface_m);
  return contents;
}

void Atlas::Spawn(KeyframeId root, const core::PoseSource& poses) {
  const auto id = static_cast<uint32_t>(submaps_.size());
  active_ = submaps_.emplace_back(std::make_unique<Submap>(id, root, Empty(), params_.cloud_filter_m)).get();
  active_->T_map_submap = poses.T_map_keyframe(root);
  travelled_m_ = 0.0;
  IntegratorParams integrator = setup_.integrator;
  if (setup_.map.keep_map) {
    integrator.region_map =
        BoxAround(*setup_.map.keep_map, active_->T_map_submap.inverse()).Inflated(kKeepMarginM);
  }
  integrator_ = MakeIntegrator<OccupancyField>(integrator, setup_.map.lidar);
}

void Atlas::Assign(const core::AnchoredSpin& spin, const core::PoseSource& poses) {
  const Pose T_map_odom = spin.T_map_odom(poses);
  const Vec3 place_map = T_map_odom * spin.spin->T_odom_lidar.poses().front().T.translation();
  UndistortHits(*spin.spin, T_map_odom, &rays_);
  const std::vector<Vec3f> cloud_map = FilterCloud(PointsOf(rays_), params_.cloud_filter_m);
  const auto cloud_in = [&](const Submap& submap) {
    const Eigen::Isometry3f T_submap_map = submap.T_map_submap.inverse().cast<float>();
    std::vector<Vec3f> cloud;
    for (const Vec3f& p : cloud_map) cloud.push_back(T_submap_map * p);
    return cloud;
  };
  if (keyframe_) travelled_m_ += (place_map - latest_place_.p_map(poses)).norm();
  const double overlap = active_ != nullptr ? active_->cloud.ShareNear(cloud_in(*active_)) : 0.0;
  const bool fits =
      active_ != nullptr && travelled_m_ <= params_.lambda_odom_m && overlap >= params_.cloud_overlap;
  if (!fits) {
    Spawn(spin.keyframe, poses);
    active_->overlap = overlap;
  }
  active_->keyframes.push_back(spin.keyframe);
  active_->cloud.Add(cloud_in(*active_));
  keyframe_ = spin.keyframe;
  latest_place_ = {spin.keyframe, poses.T_map_keyframe(spin.keyframe).inverse() * place_map};
}

void Atlas::Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) {
  Correct(poses);
  if (spin.keyframe != keyframe_) Assign(spin, poses);
  const Pose T_submap_odom = active_->T_map_submap.inverse() * spin.T_map_odom(poses);
  OctreeContents& contents = active_->contents.Write();
  integrator_->Integrate(*spin.spin, T_submap_odom, &contents.tree);
  if (contents.behind) {
    UndistortHits(*spin.spin, T_submap_odom, &rays_);
    contents.behind->Mark(rays_, setup_.integrator.max_range_m);
  }
  active_->bounds_submap = BoundsOf(contents.tree);
  active_->latest = ++revolutions_;
}

void Atlas::Correct(const core::PoseSource& poses) {
  for (const auto& submap : submaps_) submap->T_map_submap = poses.T_map_keyframe(submap->root);
}

std::shared_ptr<const AtlasView> Atlas::Snapshot() const {
  std::vector<const Submap*> newest_first;
  for (const auto& submap : submaps_) newest_first.push_back(submap.get());
  std::sort(newest_first.begin(), newest_first.end(),
            [](const Submap* a, const Submap* b) { return a->latest > b->latest; });
  std::vector<PosedSubmap> posed;
  for (const Submap* submap : newest_first) {
    posed.push_back({submap->id, OctreeView(submap->contents.Share(), StatesOf(setup_.integrator)),
                     submap->T_map_submap, submap->bounds_submap});
  }
  return std::make_shared<const AtlasView>(setup_.resolution_m, std::move(posed),
                                           setup_.map.keep_map.value_or(Everywhere()));
}

size_t Atlas::Bytes() const {
  size_t bytes = 0;
  for (const auto& submap : submaps_) {
    const OctreeContents& contents = submap->contents.Read();
    bytes += contents.tree.Bytes() + (contents.behind ? contents.behind->Bytes() : 0) + submap->cloud.Bytes();
  }
  return bytes;
}

}  // namespace atlas::mapping
