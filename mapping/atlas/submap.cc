#include "mapping/atlas/submap.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "mapping/atlas/submap_fusion.h"

namespace atlas::mapping {

using core::Pose;
using core::Vec3f;

Submap::Submap(uint32_t number, core::KeyframeId root_keyframe, PagedContents empty, double filter_m)
    : id(number), root(root_keyframe), contents(std::move(empty)) {
  clouds.push_back({Pose::Identity(), OverlapCloud(filter_m)});
}

void Submap::MoveTo(const core::PoseSource& poses) {
  T_map_submap = poses.T_map_keyframe(root);
  for (HeldKeyframe& held : keyframes) held.T_map_keyframe = poses.T_map_keyframe(held.sensor.keyframe);
}

std::shared_ptr<const SubmapOutline> Submap::Outline() const {
  const std::lock_guard lock(outline_mutex_);
  if (!outline_ || outlined_ != revision) {
    outline_ = std::make_shared<const SubmapOutline>(OutlineOf(*contents.Read()));
    outlined_ = revision;
  }
  return outline_;
}

std::vector<Vec3f> Submap::InCloud(size_t cloud, const std::vector<Vec3f>& cloud_map) const {
  const Eigen::Isometry3f T_cloud_map = (T_map_submap * clouds[cloud].T_submap_cloud).inverse().cast<float>();
  std::vector<Vec3f> points;
  points.reserve(cloud_map.size());
  for (const Vec3f& p : cloud_map) points.push_back(T_cloud_map * p);
  return points;
}

Submap::CloudMatch Submap::BestCloud(const std::vector<Vec3f>& cloud_map, double above) const {
  CloudMatch best;
  for (size_t cloud = 0; cloud < clouds.size(); ++cloud) {
    const double least = std::max(above, best.share);
    const double share = clouds[cloud].points.ShareNear(InCloud(cloud, cloud_map), least);
    if (share > least) best = {share, cloud};
  }
  return best;
}

void Submap::AddToCloud(size_t cloud, const std::vector<Vec3f>& cloud_map) {
  clouds[cloud].points.Add(InCloud(cloud, cloud_map));
}

void Submap::Absorb(Submap* other) {
  const Pose T_this_other = T_map_submap.inverse() * other->T_map_submap;
  FuseInto(*other->contents.Read(), T_this_other, FusionRule::kAdd, &*contents.Write());
  ++revision;
  std::vector<HeldKeyframe> all;
  std::merge(keyframes.begin(), keyframes.end(), other->keyframes.begin(), other->keyframes.end(),
             std::back_inserter(all),
             [](const auto& a, const auto& b) { return a.sensor.keyframe < b.sensor.keyframe; });
  keyframes = std::move(all);
  for (AccumulatedCloud& cloud : other->clouds) {
    cloud.T_submap_cloud = T_this_other * cloud.T_submap_cloud;
    clouds.push_back(std::move(cloud));
  }
  beyond.insert(other->beyond.begin(), other->beyond.end());
  latest = std::max(latest, other->latest);
}

size_t Submap::Bytes() const {
  size_t bytes = contents.ResidentBytes();
  for (const AccumulatedCloud& cloud : clouds) bytes += cloud.points.Bytes();
  return bytes;
}

}  // namespace atlas::mapping
