// Scalar reference of the cone integrator, stage 4: log-odds updates around the returns of a scan by Eq. 4.2.
//
// The voxel of a return gains hit_nats. Along the beam voxels behind it follow the ramp of Eq. 4.2 up to
// lambda_r d, at most four; in front of it those within 3 sigma, at most two; d is the signed distance of the
// voxel's centre behind the return's plane, which is moved towards the sensor by the voxel's support. Far
// oblique beams go on in front, while the plane is within two voxels. Of several updates of a voxel the
// greatest holds.
#pragma once

#include <map>
#include <tuple>

#include "mapping/octree/fields.h"
#include "tests/support/cone_reference_image.h"

namespace atlas::tests::cone {

using Field = mapping::OccupancyField;
using Voxel = std::tuple<int, int, int>;

/// A return in voxels of the map's lattice.
struct Return {
  Vec3 end, along, inward;  ///< the end, unit direction of the beam, unit normal into the surface
  double range = 0.0;
  Voxel voxel;

  double Support() const { return 0.5 * inward.lpNorm<1>(); }
  /// Of a voxel's centre behind the moved plane.
  double Distance(const Voxel& v) const {
    const auto& [x, y, z] = v;
    return inward.dot(Vec3(x + 0.5, y + 0.5, z + 0.5) - end) + Support();
  }
};

/// The voxels that a line crosses from `p` on, the first excluded.
inline std::vector<Voxel> VoxelsAlong(const Vec3& p, const Vec3& direction, int count) {
  int at[3], step[3];
  double next[3], per[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = static_cast<int>(std::floor(p[a]));
    step[a] = direction[a] > 0.0 ? 1 : -1;
    const bool moves = std::abs(direction[a]) > 1e-9;
    per[a] = moves ? 1.0 / std::abs(direction[a]) : 1e30;
    next[a] = moves ? (direction[a] > 0.0 ? at[a] + 1 - p[a] : p[a] - at[a]) * per[a] : 1e30;
  }
  std::vector<Voxel> voxels;
  for (int k = 0; k < count; ++k) {
    const int a = next[0] < next[1] && next[0] < next[2] ? 0 : next[1] < next[2] ? 1 : 2;
    at[a] += step[a];
    next[a] += per[a];
    voxels.emplace_back(at[0], at[1], at[2]);
  }
  return voxels;
}

class SurfaceUpdates {
 public:
  SurfaceUpdates(const mapping::IntegratorParams& params, double resolution)
      : params_(params), resolution_(resolution) {
    hit_ = Field::StepsOf(params.hit_nats);
    near_ = std::min(Field::StepsOf(params.near_nats), hit_ - Field::kPlaces);
    miss_ = Field::StepsOf(params.miss_nats);
  }

  /// The returns of the cells by rows, in groups of 16 columns, then the spare ones.
  void Scatter(const RangeImage& image, const core::Pose& T_map_lidar) {
    dense_range_ = 0.5 / image.beams.min_pitch;
    constexpr int kGroup = 16;
    for (int row = 0; row < image.beams.rows; ++row) {
      for (int first = 0; first < image.beams.columns; first += kGroup) {
        Queue(image, row, std::min(first, image.beams.columns - kGroup), T_map_lidar);
      }
    }
    for (const auto& [at, ray] : image.spare) {
      const Cell& cell = image.cells[at];
      const bool near = cell.range > 0.0 && std::abs(cell.range - ray.range) < resolution_;
      queue_.push_back(ReturnOf(ray.end, near ? cell.normal : Vec3(-ray.end / ray.range), T_map_lidar));
      TakeGroups(kGroup);
    }
    TakeGroups(1);
  }

  /// In units of the field.
  const std::map<Voxel, int>& values() const { return value_; }

 private:
  Return ReturnOf(const Vec3& end, const Vec3& normal, const core::Pose& T_map_lidar) const {
    Return r;
    r.end = T_map_lidar * end / resolution_;
    r.along = T_map_lidar.linear() * end.normalized();
    r.inward = -(T_map_lidar.linear() * normal);
    r.range = end.norm() / resolution_;
    r.voxel = {static_cast<int>(std::floor(r.end.x())), static_cast<int>(std::floor(r.end.y())),
               static_cast<int>(std::floor(r.end.z()))};
    return r;
  }
  /// A return whose voxel holds one already repeats it, trail and all.
  bool Repeats(const Return& r) const {
    const auto held = value_.find(r.voxel);
    return held != value_.end() && held->second >= hit_;
  }

  /// Near the sensor, returns that repeat what is there, or the return before them, are left out.
  void Queue(const RangeImage& image, int row, int first, const core::Pose& T_map_lidar) {
    const Return* before = nullptr;
    std::vector<Return> group(16);
    for (int i = 0; i < 16; ++i) {
      const Cell& cell = image.At(row, first + i);
      Return& r = group[static_cast<size_t>(i)];
      const bool hit = cell.range > 0.0;
      if (hit) r = ReturnOf(cell.end, cell.normal, T_map_lidar);
      const bool dense = hit && r.range < dense_range_;
      const bool repeats = dense && (Repeats(r) || (before != nullptr && before->voxel == r.voxel));
      if (hit && !repeats) queue_.push_back(r);
      before = dense ? &r : nullptr;
    }
    TakeGroups(16);
  }

  /// Sixteen returns at a time, each judged by what was held before its group.
  void TakeGroups(size_t least) {
    while (queue_.size() >= least) {
      std::vector<Return> fresh;
      const size_t count = std::min<size_t>(queue_.size(), 16);
      for (size_t i = 0; i < count; ++i) {
        if (!Repeats(queue_[i])) fresh.push_back(queue_[i]);
      }
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<ptrdiff_t>(count));
      for (const Return& r : fresh) Trail(r);
    }
  }

  void Raise(const Voxel& voxel, int update) {
    const auto [at, added] = value_.emplace(voxel, update);
    if (!added) at->second = std::max(at->second, update);
  }

  void Trail(const Return& r) {
    const double band = 3.0 * std::max(params_.sigma_min_m / resolution_, params_.lambda_sigma * r.range);
    const double most = std::max(params_.behind_max_m / resolution_, params_.behind_min_voxels);
    const double depth = std::clamp(params_.lambda_r * r.range, params_.behind_min_voxels, most);
    const double place = std::floor(Field::kPlaces * r.Distance(r.voxel) / (2.0 * r.Support()));
    Raise(r.voxel, hit_ + static_cast<int>(std::clamp(place, 0.0, Field::kPlaces - 1.0)));

    const double cosine = r.along.dot(r.inward);
    if (cosine < params_.skim_cosine) return;
    for (const Voxel& v : VoxelsAlong(r.end, r.along, 4)) {
      if (r.Distance(v) > depth) break;
      Raise(v, Update(r.Distance(v), band, depth, Field::kPlaces - 1));
    }
    const std::vector<Voxel> back = VoxelsAlong(r.end, -r.along, 32);
    for (size_t k = 0; k < 2 && r.Distance(back[k]) > -band; ++k) {
      Raise(back[k], Update(r.Distance(back[k]), band, depth, 0));
    }
    // Far beams at an oblique incidence stay near the plane: they go on, out of the band in the first two.
    if (r.range < dense_range_ || cosine >= 0.5) return;
    for (size_t k = 0; k < back.size() && r.Distance(back[k]) > -2.0; ++k) {
      if (k >= 2 || r.Distance(back[k]) <= -band) Raise(back[k], Update(r.Distance(back[k]), band, depth, 0));
    }
  }

  /// Eq. 4.2 in whole steps, never 0: the surface just cuts the voxels in front of the return, and lies
  /// wholly before those behind, whose place is the last.
  int Update(double distance, double band, double depth, int place) const {
    const double value = distance <= -band ? -miss_ : miss_ / band * std::min(distance, 0.5 * depth);
    const int steps = static_cast<int>(std::floor(value / Field::kPlaces + 0.5));
    if (distance < 0.0) return Field::kPlaces * std::min(steps, -1);
    return std::min(Field::kPlaces * std::max(steps, 1), near_) | place;
  }

  mapping::IntegratorParams params_;
  double resolution_, dense_range_ = 0.0;
  int hit_ = 0, near_ = 0, miss_ = 0;
  std::vector<Return> queue_;
  std::map<Voxel, int> value_;
};

}  // namespace atlas::tests::cone
