#include "mapping/backends/octomap_mapper.h"

#include <octomap/OcTree.h>

#include <sstream>
#include <utility>

#include "core/files.h"
#include "mapping/backends/sweep_cloud.h"
#include "mapping/grid/dense_grid.h"
#include "mapping/undistort.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

float LogOdds(double p) {
  return static_cast<float>(std::log(p / (1.0 - p)));
}

class OctomapMapper : public Mapper {
 public:
  OctomapMapper(const MapperParams& params, const core::Box3& object_box)
      : params_(params),
        tree_(params.resolution_m),
        grid_(object_box.Inflated(params.region_margin_m), params.resolution_m),
        log_odds_(grid_.frame().count(), 0.0f),
        mark_(grid_.frame().count(), kUntouched),
        changed_mark_(grid_.frame().count(), false),
        ended_(grid_.frame().count(), 0) {
    tree_.setProbHit(params.hit_probability);
    tree_.setProbMiss(params.miss_probability);
    tree_.setClampingThresMin(params.clamp_min);
    tree_.setClampingThresMax(params.clamp_max);
    hit_ = LogOdds(params.hit_probability);
    miss_ = LogOdds(params.miss_probability);
    clamp_min_ = LogOdds(params.clamp_min);
    clamp_max_ = LogOdds(params.clamp_max);
  }

  core::PointCloud Integrate(const core::Sweep& sweep) override {
    SweepCloud cloud(params_, grid_.region());
    UndistortedSpin spin;
    for (const core::SpinEvent& event : sweep.spins) {
      Undistort(event, sweep.T_map_odom, &spin);
      ++spin_;
      MarkHits(spin);
      MarkFree(spin);
      ApplyMarks();
      cloud.Add(spin);
    }
    view_is_old_ = true;
    return cloud.Take();
  }

  const OccupancyView& view() const override {
    if (std::exchange(view_is_old_, false)) grid_.FinishUpdate();
    return grid_;
  }

  size_t MapBytes() const override {
    WriteThrough();
    return tree_.memoryUsage() + grid_.Bytes() + log_odds_.size() * 2 * sizeof(float) + mark_.size();
  }

  std::string Save(const std::filesystem::path& directory) const override {
    WriteThrough();
    octomap::OcTree copy(tree_);
    std::ostringstream out;
    copy.writeBinary(out);
    core::WriteFileAtomically(directory / "map.bt", out.str());
    return "map.bt";
  }

 private:
  enum Mark : uint8_t { kUntouched, kFreeMark, kHitMark };

  void Touch(size_t index, Mark mark) {
    if (mark_[index] == kUntouched) touched_.push_back(index);
    mark_[index] = std::max(mark_[index], static_cast<uint8_t>(mark));
  }

  void MarkHits(const UndistortedSpin& spin) {
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > static_cast<float>(params_.max_range_m)) continue;
      const Vec3 direction = ray.direction_map.cast<double>();
      const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
      const int64_t index = grid_.frame().IndexAt(end);
      if (index < 0 || mark_[static_cast<size_t>(index)] == kHitMark) continue;
      Touch(static_cast<size_t>(index), kHitMark);
      MarkBehindSurface(end, direction, params_.behind_surface_m, &grid_);
    }
  }

  void MarkFree(const UndistortedSpin& spin) {
    for (const MapRay& ray : spin.hits) {
      MarkFreeAlong(ray, std::min(static_cast<double>(ray.range_m), params_.max_range_m));
    }
    if (params_.void_rays == "ignore") return;
    for (const MapRay& ray : spin.voids) MarkFreeAlong(ray, params_.void_range_m);
  }

  /// Rays of a spin that leave the region (or end) in the same voxel cross the same voxels, but for a few:
  /// the first one speaks for all, as in the library's discretised insertion.
  bool FirstToEndThere(const Vec3& origin, const Vec3& direction, double range_m) {
    const auto span = grid_.region().Clip(origin, direction);
    if (!span || span->first >= range_m) return false;
    const int64_t index =
        grid_.frame().IndexAt(origin + (std::min(span->second, range_m) - 1e-6) * direction);
    if (index < 0) return true;
    uint32_t& spin = ended_[static_cast<size_t>(index)];
    if (spin == spin_) return false;
    spin = spin_;
    return true;
  }

  void MarkFreeAlong(const MapRay& ray, double range_m) {
    if (!FirstToEndThere(ray.origin_map.cast<double>(), ray.direction_map.cast<double>(), range_m)) return;
    grid_.frame().Walk(ray.origin_map.cast<double>(), ray.direction_map.cast<double>(), range_m,
                       [&](size_t index, double, double) {
                         if (mark_[index] == kUntouched) {
                           mark_[index] = kFreeMark;
                           touched_.push_back(index);
                         }
                         return true;
                       });
  }

  void ApplyMarks() {
    for (const size_t index : touched_) {
      const float update = mark_[index] == kHitMark ? hit_ : miss_;
      mark_[index] = kUntouched;
      const bool measured = grid_.Measured(index);
      const float value = std::clamp(log_odds_[index] + update, clamp_min_, clamp_max_);
      if (measured && value == log_odds_[index]) continue;
      log_odds_[index] = value;
      grid_.SetLogOdds(index, value);
      if (!changed_mark_[index]) {
        changed_mark_[index] = true;
        changed_.push_back(index);
      }
    }
    touched_.clear();
  }

  /// Brings the octree up to the mirror. The tree is read only by MapBytes() and Save(), so that many sweeps
  /// cost one pass.
  void WriteThrough() const {
    if (changed_.empty()) return;
    for (const size_t index : changed_) {
      changed_mark_[index] = false;
      const Vec3 p = grid_.frame().CenterOf(index);
      tree_.setNodeValue(p.x(), p.y(), p.z(), log_odds_[index], true);
    }
    changed_.clear();
    tree_.updateInnerOccupancy();
  }

  MapperParams params_;
  mutable octomap::OcTree tree_;  ///< lags behind the mirror by changed_
  mutable DenseGrid grid_;
  mutable bool view_is_old_ = false;  ///< the mirror's lists of occupied voxels lag behind it
  std::vector<float> log_odds_;
  std::vector<uint8_t> mark_;
  mutable std::vector<bool> changed_mark_;
  std::vector<uint32_t> ended_;  ///< the last spin whose ray ended in this voxel
  uint32_t spin_ = 0;
  std::vector<size_t> touched_;
  mutable std::vector<size_t> changed_;
  float hit_, miss_, clamp_min_, clamp_max_;
};

}  // namespace

std::unique_ptr<Mapper> BuildOctomapMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>&) {
  return std::make_unique<OctomapMapper>(params, object_box);
}

}  // namespace atlas::mapping
