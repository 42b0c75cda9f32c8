#include "mapping/atlas/fusion_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace atlas::mapping {
namespace {

using core::KeyframeId;
using core::Pose;
using core::PoseSource;

/// Keyframes up to `reach_m` along the way from one, in both directions (thesis Eq. 4.3).
std::pair<KeyframeId, KeyframeId> AlongTheWay(KeyframeId from, double reach_m, const PoseSource& poses) {
  const auto step = [&](KeyframeId a) {
    return (poses.T_map_keyframe(a + 1).translation() - poses.T_map_keyframe(a).translation()).norm();
  };
  KeyframeId first = from, last = from;
  for (double way = 0.0; first > 0 && (way += step(first - 1)) < reach_m;) --first;
  for (double way = 0.0; last < poses.latest() && (way += step(last)) < reach_m;) ++last;
  return {first, last};
}

/// The places of the submaps that hold one of the keyframes from first to last.
void AddHolders(const Submaps& submaps, std::pair<KeyframeId, KeyframeId> range, std::set<size_t>* holders) {
  for (size_t i = 0; i < submaps.size(); ++i) {
    for (const HeldKeyframe& held : submaps[i]->keyframes) {
      const KeyframeId id = held.sensor.keyframe;
      if (id >= range.first && id <= range.second) holders->insert(i);
    }
  }
}

double GreaterOf(const SubmapOverlap& overlap) {
  return std::max(overlap.of_read, overlap.of_ref);
}

}  // namespace

bool FusionSearch::SureEnough(KeyframeId a, KeyframeId b, const PoseSource& poses) const {
  if (params_.sigma_max_m == 0.0) return true;
  const std::optional<double> sigma_m = poses.RelativeSigmaM(a, b);
  return sigma_m && *sigma_m <= params_.sigma_max_m;
}

bool FusionSearch::OnOneLevel(KeyframeId a, KeyframeId b, const PoseSource& poses) const {
  if (params_.level_m == 0.0) return true;
  const double z_a = poses.T_map_keyframe(a).translation().z(),
               z_b = poses.T_map_keyframe(b).translation().z();
  return std::abs(z_a - z_b) <= params_.level_m;
}

bool FusionSearch::Moved(const Pose& before, const Pose& now) const {
  const Pose between = before.inverse() * now;
  return between.translation().norm() > params_.update_m ||
         Eigen::AngleAxisd(between.linear()).angle() > core::Radians(params_.update_deg);
}

bool FusionSearch::InRange(const Submap& a, const Submap& b, const PoseSource& poses) const {
  if (params_.fusion_range_m == 0.0) return true;
  for (const HeldKeyframe& p : a.keyframes) {
    for (const HeldKeyframe& q : b.keyframes) {
      if ((p.sensor.p_map(poses) - q.sensor.p_map(poses)).norm() <= params_.fusion_range_m) return true;
    }
  }
  return false;
}

uint64_t FusionSearch::KnownVoxelsOf(const Submap& submap) {
  constexpr uint64_t kNever = std::numeric_limits<uint64_t>::max();
  auto& [revision, known] = known_.try_emplace(submap.id, kNever, 0).first->second;
  if (revision != submap.revision) {
    revision = submap.revision;
    known = KnownVoxels(submap.contents.Read()->tree);
  }
  return known;
}

const SubmapOverlap& FusionSearch::OverlapOfPair(const Submap& a, const Submap& b) {
  const Pose T_a_b = a.T_map_submap.inverse() * b.T_map_submap;
  const auto [found, is_new] = estimates_.try_emplace({a.id, b.id});
  Estimate& estimate = found->second;
  if (!is_new && estimate.revision_a == a.revision && estimate.revision_b == b.revision &&
      !Moved(estimate.T_a_b, T_a_b))
    return estimate.overlap;
  estimate = {a.revision, b.revision, T_a_b, {}, estimate.refused};
  // Boxes tell cheaply what cannot overlap enough.
  const SubmapOverlap boxes =
      OverlapOf(BoxOf(*a.Outline(), a.T_map_submap), BoxOf(*b.Outline(), b.T_map_submap));
  if (GreaterOf(boxes) < params_.fusion_overlap) return estimate.overlap;
  const uint64_t known_a = KnownVoxelsOf(a), known_b = KnownVoxelsOf(b);
  const auto held_a = a.contents.Read(), held_b = b.contents.Read();
  const OccupancyOctree &tree_a = held_a->tree, &tree_b = held_b->tree;
  if (known_a <= known_b) {
    estimate.overlap = OverlapOf(tree_a, known_a, tree_b, known_b, T_a_b.inverse());
  } else {
    const SubmapOverlap turned = OverlapOf(tree_b, known_b, tree_a, known_a, T_a_b);
    estimate.overlap = {turned.of_ref, turned.of_read};
  }
  return estimate.overlap;
}

bool FusionSearch::Overlaps(const SubmapOverlap& overlap, bool separated) const {
  return GreaterOf(overlap) > params_.fusion_overlap &&
         std::min(overlap.of_read, overlap.of_ref) >=
             (separated ? params_.fusion_overlap : params_.fusion_overlap_both);
}

/// @pre the pair has an estimate.
bool FusionSearch::MayFuse(const Submap& a, const Submap& b, const PoseSource& poses) {
  Estimate& estimate = estimates_.at({a.id, b.id});
  if (estimate.refused == poses.version()) return false;
  if (SureEnough(a.root, b.root, poses)) return true;
  estimate.refused = poses.version();
  return false;
}

void FusionSearch::Forget(const Submaps& submaps) {
  std::set<uint32_t> there;
  for (const auto& submap : submaps) there.insert(submap->id);
  const auto gone = [&](const auto& entry) {
    return there.count(entry.first.first) == 0 || there.count(entry.first.second) == 0;
  };
  std::erase_if(estimates_, gone);
  std::erase_if(loop_tried_, gone);
  std::erase_if(known_, [&](const auto& entry) { return there.count(entry.first) == 0; });
}

std::optional<FusionSearch::Pair> FusionSearch::NextByOverlap(const Submaps& submaps, const PoseSource& poses,
                                                              std::optional<uint32_t> left_out) {
  if (params_.fusion_overlap == 0.0) return std::nullopt;
  Forget(submaps);
  std::vector<std::pair<double, Pair>> proposals;
  for (size_t b = 1; b < submaps.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      if (submaps[a]->id == left_out || submaps[b]->id == left_out) continue;
      if (!OnOneLevel(submaps[a]->root, submaps[b]->root, poses)) continue;
      if (!InRange(*submaps[a], *submaps[b], poses)) continue;
      const SubmapOverlap& overlap = OverlapOfPair(*submaps[a], *submaps[b]);
      const bool separated = submaps[a]->beyond.count(submaps[b]->id) > 0;
      if (Overlaps(overlap, separated)) proposals.push_back({GreaterOf(overlap), {a, b}});
    }
  }
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const auto& x, const auto& y) { return x.first > y.first; });
  for (const auto& [overlap, pair] : proposals) {
    if (MayFuse(*submaps[pair.first], *submaps[pair.second], poses)) return pair;
  }
  return std::nullopt;
}

std::optional<FusionSearch::Pair> FusionSearch::NextByLoop(const Submaps& submaps, const PoseSource& poses) {
  if (params_.lambda_cluster_m == 0.0) return std::nullopt;
  for (const auto& [older, younger] : poses.Loops()) {
    std::set<size_t> holders;
    AddHolders(submaps, AlongTheWay(older, params_.lambda_cluster_m, poses), &holders);
    AddHolders(submaps, AlongTheWay(younger, params_.lambda_cluster_m, poses), &holders);
    for (auto b = holders.begin(); b != holders.end(); ++b) {
      for (auto a = holders.begin(); a != b; ++a) {
        const Submap &first = *submaps[*a], &second = *submaps[*b];
        const auto [tried, is_new] = loop_tried_.try_emplace({first.id, second.id}, poses.version());
        if (!is_new && std::exchange(tried->second, poses.version()) == poses.version()) continue;
        if (OnOneLevel(first.root, second.root, poses) && SureEnough(first.root, second.root, poses))
          return Pair{*a, *b};
      }
    }
  }
  return std::nullopt;
}

}  // namespace atlas::mapping
