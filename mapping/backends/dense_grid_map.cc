// A dense occupancy grid of our own: `mapper.name: dense_grid`.
//
// OctoMap's update rule (each voxel once a revolution, hits before misses) on an array over the object's
// region: many times faster than a tree, at the price of the whole region's memory. Of the rays that end in
// one voxel the first is traced.
// @throws InputError without a box to keep.
#include "mapping/backends/builders.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/errors.h"
#include "mapping/cloud/undistort.h"
#include "mapping/copy_on_write.h"
#include "mapping/grid/dense_grid.h"
#include "mapping/io/map_file.h"
#include "mapping/octree/behind_surface.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

static_assert(kMostBehind == DenseGrid::kMostBehind);

float LogOdds(double p) {
  return static_cast<float>(std::log(p / (1.0 - p)));
}

/// The box to keep. @throws InputError without one.
const core::Box3& BoxOf(const MapSetup& setup) {
  if (!setup.keep_map) throw core::InputError("mapper.name: dense_grid keeps a box, and there is none");
  return *setup.keep_map;
}

class DenseGridMap final : public Map {
 public:
  DenseGridMap(const MapperParams& params, const MapSetup& setup)
      : params_(params),
        shared_(DenseGrid(BoxOf(setup), params.resolution_m)),
        behind_surface_(setup.behind_surface),
        log_odds_(frame().count(), 0.0f),
        mark_(frame().count(), kUntouched),
        ended_(frame().count(), 0) {
    hit_ = LogOdds(params.hit_probability);
    miss_ = LogOdds(params.miss_probability);
    clamp_min_ = LogOdds(params.clamp_min);
    clamp_max_ = LogOdds(params.clamp_max);
  }

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    Undistort(*spin.spin, spin.T_map_odom(poses), &rays_);
    DenseGrid& grid = shared_.Write();
    ++spin_;
    MarkHits(rays_, &grid);
    MarkFree(rays_);
    ApplyMarks(&grid);
    stale_ = true;
  }

  std::shared_ptr<const MapView> Snapshot() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::exchange(stale_, false)) shared_.Write().FinishUpdate();
    return shared_.Share();
  }

  size_t Bytes() const override {
    return shared_.Read().Bytes() + log_odds_.size() * sizeof(float) + mark_.size() +
           ended_.size() * sizeof(uint32_t);
  }

  /// As an octree, whose log-odds come in steps of 0.05.
  std::string Save(const std::filesystem::path& directory) const override {
    OccupancyOctree tree(params_.resolution_m);
    for (size_t i = 0; i < log_odds_.size(); ++i) {
      if (!shared_.Read().Measured(i)) continue;
      const auto held =
          static_cast<int>(std::lround(static_cast<double>(log_odds_[i]) / OccupancyField::kNatsPerUnit));
      tree.Set(
          tree.KeyAt(frame().CenterOf(i)),
          static_cast<int8_t>(std::clamp(held == 0 ? 1 : held, OccupancyField::kMin, OccupancyField::kMax)));
    }
    WriteMap(directory / "map.atlas", tree);
    return "map.atlas";
  }

 private:
  const GridFrame& frame() const { return shared_.Read().frame(); }

  enum Mark : uint8_t { kUntouched, kFreeMark, kHitMark };

  void Touch(size_t index, Mark mark) {
    if (mark_[index] == kUntouched) touched_.push_back(index);
    mark_[index] = std::max(mark_[index], static_cast<uint8_t>(mark));
  }

  void MarkHits(const UndistortedSpin& spin, DenseGrid* grid) {
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > static_cast<float>(params_.integrator.max_range_m)) continue;
      const Vec3 direction = ray.direction_map.cast<double>();
      const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
      const int64_t index = frame().IndexAt(end);
      if (index < 0 || mark_[static_cast<size_t>(index)] == kHitMark) continue;
      Touch(static_cast<size_t>(index), kHitMark);
      if (behind_surface_) MarkBehind(end, direction, grid);
    }
  }

  void MarkBehind(const Vec3& end, const Vec3& direction, DenseGrid* grid) const {
    ForEachBehind(end, direction, params_.resolution_m, params_.behind_surface_m,
                  [&](const Vec3& p_map, int value) {
                    const int64_t index = frame().IndexAt(p_map);
                    if (index >= 0) grid->SetBehindSurface(static_cast<size_t>(index), value);
                    return index >= 0;
                  });
  }

  void MarkFree(const UndistortedSpin& spin) {
    for (const MapRay& ray : spin.hits) {
      MarkFreeAlong(ray, std::min(static_cast<double>(ray.range_m), params_.integrator.max_range_m));
    }
    if (params_.integrator.void_rays == "ignore") return;
    for (const MapRay& ray : spin.voids) MarkFreeAlong(ray, params_.integrator.void_range_m);
  }

  /// Rays of a spin that leave the region (or end) in the same voxel cross the same voxels, but for a few:
  /// only the first one is traced (the library's discretised insertion).
  bool FirstToEndThere(const Vec3& origin, const Vec3& direction, double range_m) {
    const auto span = frame().box().Clip(origin, direction);
    if (!span || span->first >= range_m) return false;
    const int64_t index = frame().IndexAt(origin + (std::min(span->second, range_m) - 1e-6) * direction);
    if (index < 0) return true;
    uint32_t& spin = ended_[static_cast<size_t>(index)];
    if (spin == spin_) return false;
    spin = spin_;
    return true;
  }

  void MarkFreeAlong(const MapRay& ray, double range_m) {
    if (!FirstToEndThere(ray.origin_map.cast<double>(), ray.direction_map.cast<double>(), range_m)) return;
    frame().Walk(ray.origin_map.cast<double>(), ray.direction_map.cast<double>(), range_m,
                 [&](size_t index, double, double) {
                   if (mark_[index] == kUntouched) {
                     mark_[index] = kFreeMark;
                     touched_.push_back(index);
                   }
                   return true;
                 });
  }

  void ApplyMarks(DenseGrid* grid) {
    for (const size_t index : touched_) {
      const float update = mark_[index] == kHitMark ? hit_ : miss_;
      mark_[index] = kUntouched;
      const bool measured = grid->Measured(index);
      const float value = std::clamp(log_odds_[index] + update, clamp_min_, clamp_max_);
      if (measured && value == log_odds_[index]) continue;
      log_odds_[index] = value;
      grid->SetLogOdds(index, value);
    }
    touched_.clear();
  }

  MapperParams params_;
  mutable CopyOnWrite<DenseGrid> shared_;  ///< holds the log-odds in steps, for views
  mutable std::mutex mutex_;               ///< of what a snapshot finds of the voxels when it is asked for
  mutable bool stale_ = false;
  bool behind_surface_;
  std::vector<float> log_odds_;
  std::vector<uint8_t> mark_;
  std::vector<uint32_t> ended_;  ///< the last spin whose ray ended in this voxel
  uint32_t spin_ = 0;
  std::vector<size_t> touched_;
  UndistortedSpin rays_;
  float hit_, miss_, clamp_min_, clamp_max_;
};

}  // namespace

std::unique_ptr<Map> BuildDenseGridMap(const MapperParams& params, const MapSetup& setup) {
  return std::make_unique<DenseGridMap>(params, setup);
}

}  // namespace atlas::mapping
