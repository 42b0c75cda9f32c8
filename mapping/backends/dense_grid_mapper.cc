#include "mapping/backends/dense_grid_mapper.h"

#include <algorithm>
#include <cmath>

#include "mapping/backends/behind_surface.h"
#include "mapping/backends/on_demand.h"
#include "mapping/cloud/undistort.h"
#include "mapping/grid/dense_grid.h"
#include "mapping/io/map_file.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

float LogOdds(double p) {
  return static_cast<float>(std::log(p / (1.0 - p)));
}

class DenseGridMapper : public Mapper {
 public:
  DenseGridMapper(const MapperParams& params, const core::Box3& object_box)
      : params_(params),
        grid_(object_box.Inflated(params.region_margin_m), params.resolution_m),
        log_odds_(grid_.frame().count(), 0.0f),
        mark_(grid_.frame().count(), kUntouched),
        ended_(grid_.frame().count(), 0) {
    hit_ = LogOdds(params.hit_probability);
    miss_ = LogOdds(params.miss_probability);
    clamp_min_ = LogOdds(params.clamp_min);
    clamp_max_ = LogOdds(params.clamp_max);
  }

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    Undistort(*spin.spin, spin.T_map_odom(poses), &rays_);
    ++spin_;
    MarkHits(rays_);
    MarkFree(rays_);
    ApplyMarks();
    blocks_.Request();
  }

  const OccupancyView& view() const override {
    blocks_.Ensure([this] { grid_.FinishUpdate(); });
    return grid_;
  }

  size_t MapBytes() const override {
    view();
    return grid_.Bytes() + log_odds_.size() * sizeof(float) + mark_.size() + ended_.size() * sizeof(uint32_t);
  }

  /// As an octree, whose log-odds come in steps of 0.05.
  std::string Save(const std::filesystem::path& directory) const override {
    OccupancyOctree tree(params_.resolution_m);
    for (size_t i = 0; i < log_odds_.size(); ++i) {
      if (!grid_.Measured(i)) continue;
      const auto held =
          static_cast<int>(std::lround(static_cast<double>(log_odds_[i]) / OccupancyField::kNatsPerUnit));
      tree.Set(
          tree.KeyAt(grid_.frame().CenterOf(i)),
          static_cast<int8_t>(std::clamp(held == 0 ? 1 : held, OccupancyField::kMin, OccupancyField::kMax)));
    }
    WriteMap(directory / "map.atlas", tree);
    return "map.atlas";
  }

 private:
  enum Mark : uint8_t { kUntouched, kFreeMark, kHitMark };

  void Touch(size_t index, Mark mark) {
    if (mark_[index] == kUntouched) touched_.push_back(index);
    mark_[index] = std::max(mark_[index], static_cast<uint8_t>(mark));
  }

  void MarkHits(const UndistortedSpin& spin) {
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > static_cast<float>(params_.integrator.max_range_m)) continue;
      const Vec3 direction = ray.direction_map.cast<double>();
      const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
      const int64_t index = grid_.frame().IndexAt(end);
      if (index < 0 || mark_[static_cast<size_t>(index)] == kHitMark) continue;
      Touch(static_cast<size_t>(index), kHitMark);
      MarkBehindSurface(grid_.frame(), end, direction, params_.behind_surface_m,
                        [this](size_t i, int value) { grid_.SetBehindSurface(i, value); });
    }
  }

  void MarkFree(const UndistortedSpin& spin) {
    for (const MapRay& ray : spin.hits) {
      MarkFreeAlong(ray, std::min(static_cast<double>(ray.range_m), params_.integrator.max_range_m));
    }
    if (params_.integrator.void_rays == "ignore") return;
    for (const MapRay& ray : spin.voids) MarkFreeAlong(ray, params_.integrator.void_range_m);
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
    }
    touched_.clear();
  }

  MapperParams params_;
  OnDemand blocks_;         ///< of the grid: what it finds of its voxels when it is asked for
  mutable DenseGrid grid_;  ///< holds the log-odds in steps, for the view
  std::vector<float> log_odds_;
  std::vector<uint8_t> mark_;
  std::vector<uint32_t> ended_;  ///< the last spin whose ray ended in this voxel
  uint32_t spin_ = 0;
  std::vector<size_t> touched_;
  UndistortedSpin rays_;
  float hit_, miss_, clamp_min_, clamp_max_;
};

}  // namespace

std::unique_ptr<Mapper> BuildDenseGridMapper(const MapperParams& params, const core::Box3& object_box,
                                             const std::optional<core::LidarModel>&) {
  return std::make_unique<DenseGridMapper>(params, object_box);
}

}  // namespace atlas::mapping
