#include "mapping/backends/se_atlas_mapper.h"

#include <array>
#include <utility>

#include "mapping/backends/behind_surface.h"
#include "mapping/backends/on_demand.h"
#include "mapping/cloud/undistort.h"
#include "mapping/grid/dense_grid.h"
#include "mapping/integrator/integrator.h"
#include "mapping/io/map_file.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;
using Field = OccupancyField;

/// A voxel counts as occupied from this share of a scan's miss on: the least that Eq. 4.2 gives behind a near
/// surface.
constexpr double kSurfaceShare = 0.75;

/// Free nodes keep the least that is known of their voxels, and cones claim free space only where no beam
/// contradicts, so one scan's miss decides free, and as much evidence as a scan gives of a surface decides
/// occupied (thesis 4.5.2: negative is free, positive occupied). Voxels between have seen both.
StateLogOdds StatesOf(const IntegratorParams& params) {
  const double miss = Field::kNatsPerUnit * Field::StepsOf(params.miss_nats);
  return {-miss, kSurfaceShare * miss};
}

static_assert(DenseGrid::kLogOddsStep == Field::kNatsPerUnit);

class SeAtlasMapper : public Mapper {
 public:
  SeAtlasMapper(const MapperParams& params, const core::Box3& object_box,
                const std::optional<core::LidarModel>& lidar)
      : params_(params),
        tree_(params.resolution_m),
        grid_(object_box.Inflated(params.region_margin_m), params.resolution_m, StatesOf(params.integrator)),
        last_hit_(grid_.frame().count(), 0) {
    IntegratorParams integrator = params.integrator;
    integrator.region_map = grid_.region();
    integrator_ =
        lidar ? MakeConeIntegrator<Field>(integrator, *lidar) : MakeRayIntegrator<Field>(integrator);
    for (int v = -128; v < 128; ++v) {
      const double log_odds = Field::LogOdds(static_cast<int8_t>(v));
      code_[static_cast<uint8_t>(v)] = DenseGrid::CodeOf(static_cast<float>(log_odds));
    }
  }

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    const core::Pose T_map_odom = spin.T_map_odom(poses);
    integrator_->Integrate(*spin.spin, T_map_odom, &tree_);
    UndistortHits(*spin.spin, T_map_odom, &rays_);
    MarkBehind(rays_);
    mirror_.Request();
  }

  const OccupancyView& view() const override {
    mirror_.Ensure([this] {
      for (const auto& [chunk, blocks] : tree_.TakeChanges()) Mirror(*tree_.Find(chunk), blocks);
      grid_.FinishUpdate();
    });
    return grid_;
  }

  size_t MapBytes() const override {
    view();
    return tree_.Bytes() + grid_.Bytes() + last_hit_.size();
  }

  std::string Save(const std::filesystem::path& directory) const override {
    WriteMap(directory / "map.atlas", tree_);
    return "map.atlas";
  }

 private:
  /// Once a spin for each voxel that was hit, by its first ray.
  void MarkBehind(const UndistortedSpin& spin) {
    if (++spin_ == 0) {
      std::fill(last_hit_.begin(), last_hit_.end(), uint8_t{0});
      spin_ = 1;
    }
    const core::Box3 near = grid_.region().Inflated(params_.resolution_m);  // most hits lie elsewhere
    const Vec3f near_min = near.min.cast<float>(), near_max = near.max.cast<float>();
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > static_cast<float>(params_.integrator.max_range_m)) continue;
      const Vec3f end_float = ray.origin_map + ray.range_m * ray.direction_map;
      if ((end_float.array() < near_min.array()).any() || (end_float.array() > near_max.array()).any())
        continue;
      const Vec3 direction = ray.direction_map.cast<double>();
      const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
      const int64_t index = grid_.frame().IndexAt(end);
      if (index < 0 || std::exchange(last_hit_[static_cast<size_t>(index)], spin_) == spin_) continue;
      MarkBehindSurface(grid_.frame(), end, direction, params_.behind_surface_m,
                        [this](size_t i, int value) { grid_.SetBehindSurface(i, value); });
    }
  }

  /// Copies the log-odds of a chunk's measured voxels into the grid, exactly: both hold steps of 0.05.
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
  OnDemand mirror_;               ///< the grid takes over the octree's changes when it is asked for
  mutable OccupancyOctree tree_;  ///< mutable for its marks of what the grid lacks
  mutable DenseGrid grid_;
  std::unique_ptr<ScanIntegrator<Field>> integrator_;
  std::array<uint8_t, 256> code_;  ///< of the grid, by log-odds (as unsigned)
  std::vector<uint8_t> last_hit_;  ///< the last spin that hit a voxel, counted to 255
  uint8_t spin_ = 0;
  UndistortedSpin rays_;
};

}  // namespace

std::unique_ptr<Mapper> BuildSeAtlasMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>& lidar) {
  return std::make_unique<SeAtlasMapper>(params, object_box, lidar);
}

}  // namespace atlas::mapping
