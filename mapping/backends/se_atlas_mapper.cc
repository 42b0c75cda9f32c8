#include "mapping/backends/se_atlas_mapper.h"

#include <array>
#include <utility>

#include "mapping/backends/sweep_cloud.h"
#include "mapping/grid/dense_grid.h"
#include "mapping/integrator/integrator.h"
#include "mapping/io/map_file.h"
#include "mapping/undistort.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;
using Field = OccupancyField;

/// Of a scan's miss: the evidence behind a surface that Eq. 4.2 gives near the sensor, rounded down.
constexpr double kSurfaceShare = 0.75;

IntegratorParams IntegratorParamsOf(const MapperParams& params, const core::Box3& region) {
  IntegratorParams integrator;
  integrator.max_range_m = params.max_range_m;
  integrator.void_rays = params.void_rays;
  integrator.void_range_m = params.void_range_m;
  integrator.region_map = region;
  // Sweeps from near by: what is held without a return is cleared sooner than from afar.
  integrator.near_nats = 0.2;
  // Beams that skim a surface return far apart: what lies between is left for another view.
  integrator.skim_cosine = 0.5;
  // Behind a surface that ends, evidence would hide what the next view is to find.
  integrator.behind_max_m = integrator.behind_min_voxels * params.resolution_m;
  return integrator;
}

class SeAtlasMapper : public Mapper {
 public:
  SeAtlasMapper(const MapperParams& params, const core::Box3& object_box,
                const std::optional<core::LidarModel>& lidar)
      : params_(params),
        tree_(params.resolution_m),
        grid_(object_box.Inflated(params.region_margin_m), params.resolution_m),
        last_hit_(grid_.frame().count(), 0) {
    const IntegratorParams integrator = IntegratorParamsOf(params, grid_.region());
    integrator_ =
        lidar ? MakeConeIntegrator<Field>(integrator, *lidar) : MakeRayIntegrator<Field>(integrator);
    for (int v = -128; v < 128; ++v) {
      code_[static_cast<uint8_t>(v)] = DenseGrid::CodeOf(ViewLogOdds(static_cast<int8_t>(v), integrator));
    }
  }

  core::PointCloud Integrate(const core::Sweep& sweep) override {
    SweepCloud cloud(params_, grid_.region());
    UndistortedSpin spin;
    for (const core::SpinEvent& event : sweep.spins) {
      integrator_->Integrate(event, sweep.T_map_odom, &tree_);
      UndistortHits(event, sweep.T_map_odom, &spin);
      MarkBehind(spin);
      cloud.Add(spin);
    }
    view_is_old_ = true;
    return cloud.Take();
  }

  const OccupancyView& view() const override {
    if (std::exchange(view_is_old_, false)) {
      for (const auto& [chunk, blocks] : tree_.TakeChanges()) Mirror(*tree_.Find(chunk), blocks);
      grid_.FinishUpdate();
    }
    return grid_;
  }

  size_t MapBytes() const override { return tree_.Bytes() + grid_.Bytes() + last_hit_.size(); }

  std::string Save(const std::filesystem::path& directory) const override {
    WriteMap(directory / "map.atlas", tree_);
    return "map.atlas";
  }

 private:
  /// What planners are told of a voxel's log-odds. Free nodes keep the least that is known of their voxels,
  /// and cones claim free space only where no beam contradicts, so a scan's miss decides free; as much
  /// evidence as a scan gives of a surface decides occupied (thesis 4.5.2: negative is free, positive
  /// occupied). What lies between has seen both.
  float ViewLogOdds(int8_t value, const IntegratorParams& integrator) const {
    const double log_odds = Field::LogOdds(value);
    const auto of = [](double p) { return std::log(p / (1.0 - p)); };
    if (log_odds <= -integrator.miss_nats + 1e-6) return static_cast<float>(of(params_.clamp_min));
    if (log_odds >= kSurfaceShare * integrator.miss_nats - 1e-6) {
      return static_cast<float>(of(params_.clamp_max));
    }
    return static_cast<float>(log_odds);
  }

  /// Once a spin for each voxel that was hit, by its first ray.
  void MarkBehind(const UndistortedSpin& spin) {
    if (++spin_ == 0) {
      std::fill(last_hit_.begin(), last_hit_.end(), uint8_t{0});
      spin_ = 1;
    }
    const core::Box3 near = grid_.region().Inflated(params_.resolution_m);  // most hits lie elsewhere
    const Vec3f near_min = near.min.cast<float>(), near_max = near.max.cast<float>();
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > static_cast<float>(params_.max_range_m)) continue;
      const Vec3f end_float = ray.origin_map + ray.range_m * ray.direction_map;
      if ((end_float.array() < near_min.array()).any() || (end_float.array() > near_max.array()).any())
        continue;
      const Vec3 direction = ray.direction_map.cast<double>();
      const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
      const int64_t index = grid_.frame().IndexAt(end);
      if (index < 0 || std::exchange(last_hit_[static_cast<size_t>(index)], spin_) == spin_) continue;
      MarkBehindSurface(end, direction, params_.behind_surface_m, &grid_);
    }
  }

  /// Copies the measured voxels of a chunk's blocks into the grid.
  void Mirror(const OccupancyOctree::Chunk& chunk, const BlockMask& blocks) const {
    OccupancyOctree::FineLeaf leaf;
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (!blocks.Test(block)) continue;
      tree_.Expand(chunk, block, &leaf);
      const NodeKey at = BlockOffset(block);
      MirrorBlock({kChunkSide * chunk.key.x + kBlockSide * at.x, kChunkSide * chunk.key.y + kBlockSide * at.y,
                   kChunkSide * chunk.key.z + kBlockSide * at.z},
                  leaf);
    }
  }

  void MirrorBlock(const NodeKey& first, const OccupancyOctree::FineLeaf& leaf) const {
    const NodeKey origin = tree_.KeyAt(grid_.region().min + Vec3::Constant(0.5 * params_.resolution_m));
    const int base[3] = {first.x - origin.x, first.y - origin.y, first.z - origin.z};
    int lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::max(0, -base[a]);
      hi[a] = std::min(kBlockSide, grid_.frame().size()[static_cast<size_t>(a)] - base[a]);
    }
    for (int k = lo[2]; k < hi[2]; ++k) {
      for (int j = lo[1]; j < hi[1]; ++j) {
        if (lo[0] >= hi[0]) return;
        const size_t row = grid_.frame().IndexOf(base[0] + lo[0], base[1] + j, base[2] + k);
        for (int i = lo[0]; i < hi[0]; ++i) {
          const int8_t value = leaf.log_odds[VoxelIndex(i, j, k)];
          if (Field::Known(value)) {
            grid_.SetCode(row + static_cast<size_t>(i - lo[0]), code_[static_cast<uint8_t>(value)]);
          }
        }
      }
    }
  }

  MapperParams params_;
  mutable OccupancyOctree tree_;  ///< mutable for its marks of what the mirror lacks
  mutable DenseGrid grid_;        ///< lags behind the octree by those
  mutable bool view_is_old_ = false;
  std::unique_ptr<ScanIntegrator<Field>> integrator_;
  std::array<uint8_t, 256> code_;  ///< of the grid, by log-odds (as unsigned)
  std::vector<uint8_t> last_hit_;  ///< the last spin that hit a voxel, counted to 255
  uint8_t spin_ = 0;
};

}  // namespace

std::unique_ptr<Mapper> BuildSeAtlasMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>& lidar) {
  return std::make_unique<SeAtlasMapper>(params, object_box, lidar);
}

}  // namespace atlas::mapping
