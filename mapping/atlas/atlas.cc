#include "mapping/atlas/atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/errors.h"
#include "mapping/atlas/distance_states.h"
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
/// A keyframe so near before a doorway sees as much of what lies beyond it.
constexpr double kBeforeDoorwayM = 1.0;

Box3 Everywhere() {
  return TraceLimits{}.box_map;
}

std::vector<Vec3f> PointsOf(const UndistortedSpin& rays) {
  std::vector<Vec3f> points;
  for (const MapRay& hit : rays.hits) points.push_back(hit.origin_map + hit.range_m * hit.direction_map);
  return points;
}

std::vector<Vec3f> Moved(const std::vector<Vec3f>& points, const Pose& T) {
  const Eigen::Isometry3f T_f = T.cast<float>();
  std::vector<Vec3f> moved;
  moved.reserve(points.size());
  for (const Vec3f& p : points) moved.push_back(T_f * p);
  return moved;
}

}  // namespace

/// As its first revolution saw the place.
struct Atlas::NewKeyframe {
  KeyframeId id;
  Vec3 place_map;  ///< of the sensor
  std::vector<Vec3f> cloud_map;
};

Atlas::Atlas(const AtlasParams& params, const AtlasSetup& setup)
    : params_(params),
      setup_(setup),
      pager_(std::make_shared<ContentsPager>(static_cast<size_t>(1e6 * params.memory_limit_mb))),
      search_(params),
      doorways_(params.doorway_m) {
  if (setup_.map.earlier) GoOnFrom(*std::exchange(setup_.map.earlier, nullptr));
}
Atlas::~Atlas() = default;

void Atlas::GoOnFrom(const SavedAtlas& earlier) {
  if (earlier.resolution_m != setup_.resolution_m) {
    throw core::InputError(fmt::format("mapper.resolution_m: {}, must be that of the atlas to go on from, {}",
                                       setup_.resolution_m, earlier.resolution_m));
  }
  for (const SavedSubmap& saved : earlier.submaps) {
    const bool distances = saved.contents->Get()->distances.has_value();
    if (distances == (params_.field == "tsdf")) continue;
    throw core::InputError(fmt::format("mapper.field: {}, must be that of the atlas to go on from, {}",
                                       params_.field, distances ? "tsdf" : "occupancy"));
  }
  revolutions_ = earlier.submaps.size();
  for (size_t i = 0; i < earlier.submaps.size(); ++i) {
    const SavedSubmap& saved = earlier.submaps[i];
    PagedContents contents(pager_, saved.contents->Get()->Clone());
    auto submap = std::make_unique<Submap>(saved.id, saved.root, std::move(contents), params_.cloud_filter_m);
    submap->T_map_submap = saved.T_map_submap;
    submap->keyframes = saved.keyframes;
    submap->overlap = saved.overlap;
    submap->latest = revolutions_ - i;
    if (!saved.clouds.empty()) submap->clouds.clear();
    for (const SavedSubmap::Cloud& cloud : saved.clouds) {
      submap->clouds.push_back({cloud.T_submap_cloud, OverlapCloud(params_.cloud_filter_m)});
      submap->clouds.back().points.Add(cloud.points);
    }
    next_id_ = std::max(next_id_, saved.id + 1);
    submaps_.push_back(std::move(submap));
    pager_->Trim();
  }
  std::sort(submaps_.begin(), submaps_.end(), [](const auto& a, const auto& b) { return a->id < b->id; });
}

PagedContents Atlas::Empty() const {
  OctreeContents contents{OccupancyOctree(setup_.resolution_m), {}};
  if (setup_.map.behind_surface) contents.behind.emplace(setup_.resolution_m, setup_.behind_surface_m);
  if (params_.field == "tsdf") contents.distances.emplace(setup_.resolution_m);
  return {pager_, std::move(contents)};
}

Submap* Atlas::Spawn(KeyframeId root, const core::PoseSource& poses) {
  submaps_.push_back(std::make_unique<Submap>(next_id_++, root, Empty(), params_.cloud_filter_m));
  submaps_.back()->T_map_submap = poses.T_map_keyframe(root);
  return submaps_.back().get();
}

void Atlas::Activate(Submap* submap) {
  active_ = submap;
  IntegratorParams integrator = setup_.integrator;
  if (setup_.map.keep_map) {
    integrator.region_map =
        BoxAround(*setup_.map.keep_map, active_->T_map_submap.inverse()).Inflated(kKeepMarginM);
  }
  if (params_.field == "tsdf") {
    distance_integrator_ = MakeIntegrator<TsdfField>(integrator, setup_.map.lidar);
  } else {
    integrator_ = MakeIntegrator<OccupancyField>(integrator, setup_.map.lidar);
  }
}

void Atlas::Fill(const core::AnchoredSpin& spin, const Pose& T_submap_odom, OctreeContents* contents) {
  if (contents->distances) {
    distance_integrator_->Integrate(*spin.spin, T_submap_odom, &*contents->distances);
    for (const auto& [chunk, blocks] : contents->distances->TakeChanges())
      TellStates(*contents->distances, chunk, blocks, &contents->tree);
  } else {
    integrator_->Integrate(*spin.spin, T_submap_odom, &contents->tree);
  }
}

Submap* Atlas::Fitting(const NewKeyframe& keyframe, bool active_too, const core::PoseSource& poses) const {
  if (!params_.reentry || params_.cloud_overlap == 0.0) return nullptr;
  std::vector<std::pair<double, Submap*>> fitting;
  for (const auto& submap : submaps_) {
    if (submap.get() == active_ && !active_too) continue;
    if (!search_.OnOneLevel(submap->root, keyframe.id, poses)) continue;
    if (!submap->Outline()->bounds.Contains(submap->T_map_submap.inverse() * keyframe.place_map)) continue;
    const double below = std::nextafter(params_.reentry_overlap, 0.0);
    const double share = submap->BestCloud(keyframe.cloud_map, below).share;
    if (share >= params_.reentry_overlap) fitting.emplace_back(share, submap.get());
  }
  std::stable_sort(fitting.begin(), fitting.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [share, submap] : fitting) {
    if (search_.SureEnough(submap->root, keyframe.id, poses)) return submap;
  }
  return nullptr;
}

void Atlas::TakeUp(Submap* next, bool beyond_doorway, const core::PoseSource& poses) {
  Submap* const left = active_;
  travelled_m_ = 0.0;
  by_doorway_ = beyond_doorway;
  Activate(next);
  if (beyond_doorway) {
    for (const auto& submap : submaps_) {
      if (same_side_.count(submap->id) == 0 || submap.get() == next) continue;
      submap->beyond.insert(next->id);
      next->beyond.insert(submap->id);
    }
    same_side_.clear();
  }
  same_side_.insert(next->id);
  if (left == nullptr || left == next) return;
  Fuse(poses, active_->id);
}

void Atlas::Assign(const core::AnchoredSpin& spin, bool beyond_doorway, const core::PoseSource& poses) {
  const Pose T_map_odom = spin.T_map_odom(poses);
  UndistortHits(*spin.spin, T_map_odom, &rays_);
  const NewKeyframe keyframe{spin.keyframe,
                             T_map_odom * spin.spin->T_odom_lidar.poses().front().T.translation(),
                             FilterCloud(PointsOf(rays_), params_.cloud_filter_m)};
  doorways_.See(Moved(keyframe.cloud_map, T_map_odom.inverse()),
                spin.spin->T_odom_lidar.poses().front().T.translation());
  const bool is_new = !keyframe_ || keyframe_->keyframe != spin.keyframe;
  if (keyframe_ && is_new) travelled_m_ += (keyframe.place_map - keyframe_->p_map(poses)).norm();
  Submap::CloudMatch match;
  if (active_ != nullptr) match = active_->BestCloud(keyframe.cloud_map);
  const double overlap = match.share;
  const bool near = travelled_m_ <= params_.lambda_odom_m,
             overlaps = overlap >= params_.cloud_overlap || doorways_.InNarrow();
  const bool on_level = active_ == nullptr || search_.OnOneLevel(active_->root, keyframe.id, poses);
  if (active_ == nullptr || !near || !overlaps || !on_level || beyond_doorway) {
    // Where overlap gave way just before a doorway, the submap beyond it may be in use already.
    const bool just_taken_up = beyond_doorway && !by_doorway_ && travelled_m_ < kBeforeDoorwayM;
    Submap* next = Fitting(keyframe, /*active_too=*/beyond_doorway ? just_taken_up : !near, poses);
    if (next == nullptr) {
      next = Spawn(keyframe.id, poses);
      next->overlap = overlap;
    }
    TakeUp(next, beyond_doorway, poses);
    match = active_->BestCloud(keyframe.cloud_map);
  }
  active_->AddToCloud(match.cloud, keyframe.cloud_map);
  if (!is_new) return;
  keyframe_ = {keyframe.id, poses.T_map_keyframe(keyframe.id).inverse() * keyframe.place_map};
  active_->keyframes.push_back({*keyframe_, poses.T_map_keyframe(keyframe.id)});
}

void Atlas::Fuse(const core::PoseSource& poses, std::optional<uint32_t> left_out) {
  while (true) {
    auto pair = search_.NextByLoop(submaps_, poses);
    if (!pair) pair = search_.NextByOverlap(submaps_, poses, left_out);
    if (!pair) return;
    Submap *const older = submaps_[pair->first].get(), *const younger = submaps_[pair->second].get();
    older->Absorb(younger);
    if (active_ == younger) Activate(older);
    for (const auto& submap : submaps_) {
      if (submap->beyond.erase(younger->id) > 0 && submap.get() != older) submap->beyond.insert(older->id);
    }
    older->beyond.erase(older->id);
    if (same_side_.erase(younger->id) > 0) same_side_.insert(older->id);
    submaps_.erase(submaps_.begin() + static_cast<std::ptrdiff_t>(pair->second));
    pager_->Trim();
  }
}

void Atlas::Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) {
  Correct(poses);
  const bool beyond_doorway = doorways_.Move(spin.spin->T_odom_lidar.poses().front().T.translation());
  if (!keyframe_ || spin.keyframe != keyframe_->keyframe || beyond_doorway)
    Assign(spin, beyond_doorway, poses);
  const Pose T_submap_odom = active_->T_map_submap.inverse() * spin.T_map_odom(poses);
  {
    const PagedContents::Writing contents = active_->contents.Write();
    Fill(spin, T_submap_odom, &*contents);
    if (contents->behind) {
      UndistortHits(*spin.spin, T_submap_odom, &rays_);
      contents->behind->Mark(rays_, setup_.integrator.max_range_m);
    }
  }
  ++active_->revision;
  active_->latest = ++revolutions_;
  pager_->Trim();
}

void Atlas::Correct(const core::PoseSource& poses) {
  for (const auto& submap : submaps_) submap->MoveTo(poses);
  if (std::exchange(version_, poses.version()) != poses.version()) Fuse(poses, std::nullopt);
}

std::vector<const Submap*> Atlas::ByPrecedence() const {
  std::vector<const Submap*> newest_first;
  for (const auto& submap : submaps_) newest_first.push_back(submap.get());
  std::sort(newest_first.begin(), newest_first.end(),
            [](const Submap* a, const Submap* b) { return a->latest > b->latest; });
  return newest_first;
}

std::shared_ptr<const AtlasView> Atlas::Snapshot() const {
  std::vector<PosedSubmap> posed;
  for (const Submap* submap : ByPrecedence()) {
    posed.push_back({submap->id, submap->contents.Share(), StatesOf(setup_.integrator), submap->T_map_submap,
                     submap->Outline()});
  }
  return std::make_shared<const AtlasView>(setup_.resolution_m, std::move(posed),
                                           setup_.map.keep_map.value_or(Everywhere()));
}

SavedAtlas Atlas::Saved() const {
  return ToSave(ByPrecedence(), setup_.resolution_m, StatesOf(setup_.integrator),
                setup_.map.keep_map.value_or(Everywhere()));
}

size_t Atlas::Bytes() const {
  size_t bytes = 0;
  for (const auto& submap : submaps_) bytes += submap->Bytes();
  return bytes;
}

}  // namespace atlas::mapping
