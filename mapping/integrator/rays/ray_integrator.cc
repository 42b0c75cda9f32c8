// Unorganised clouds, ray by ray. Rays only set bits in the blocks that they cross; then each block takes the
// scan in with one masked pass. Of the rays that end in one voxel only the
// first is traced (OctoMap's discretised insertion).
#include <algorithm>
#include <atomic>
#include <ctime>

#include "core/parallel_for.h"
#include "mapping/integrator/dynamic_loop.h"
#include "mapping/integrator/integrator.h"
#include "mapping/integrator/rays/ray_masks.h"
#include "mapping/integrator/rays/voxel_walk.h"
#include "mapping/integrator/write/block_writer.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

/// One ray in the map frame, in voxels.
struct VoxelRay {
  Vec3 origin, direction;
  double length = 0.0;
  bool hit = false;
  NodeKey end;
};

/// Rays of a scan that bear evidence, at their own poses where these move.
class ScanRays {
 public:
  ScanRays(const core::SpinEvent& spin, const core::Pose& T_map_odom, const IntegratorParams& params,
           double resolution_m)
      : spin_(spin), T_map_odom_(T_map_odom), params_(params), inverse_(1.0 / resolution_m) {
    const auto& times = spin.scan.time_s;
    const double middle = times.empty()
                              ? 0.0
                              : 0.5 * (static_cast<double>(*std::min_element(times.begin(), times.end())) +
                                       static_cast<double>(*std::max_element(times.begin(), times.end())));
    pose_ = T_map_odom * spin.T_odom_lidar.At(spin.scan.stamp_s + middle);
  }

  std::optional<VoxelRay> At(size_t i) {
    const core::LidarScan& scan = spin_.scan;
    if (scan.kind[i] == core::ReturnKind::kDropout) return std::nullopt;
    const bool returned = scan.kind[i] == core::ReturnKind::kHit;
    if (!returned && params_.void_rays == "ignore") return std::nullopt;
    const Vec3 direction = scan.direction_lidar[i].cast<double>();
    const double norm = direction.norm();
    if (!(norm > 1e-3 && norm < 1e6)) return std::nullopt;
    const double range = static_cast<double>(scan.range_m[i]) * norm;
    if (returned && !(range > 0.0)) return std::nullopt;
    UpdatePose(scan, i);
    VoxelRay ray;
    ray.hit = returned && range <= params_.max_range_m;
    ray.length = inverse_ * (ray.hit    ? range
                             : returned ? params_.max_range_m
                                        : std::min(params_.void_range_m, params_.max_range_m));
    ray.direction = pose_.linear() * (direction / norm);
    ray.origin = inverse_ * pose_.translation();
    ray.end = VoxelKeyAt(ray.origin + ray.length * ray.direction, 1.0);
    return ray;
  }

 private:
  void UpdatePose(const core::LidarScan& scan, size_t i) {
    if (!params_.motion_aware || scan.time_s.empty() || scan.time_s[i] == time_s_) return;
    time_s_ = scan.time_s[i];
    pose_ = T_map_odom_ * spin_.T_odom_lidar.At(scan.stamp_s + static_cast<double>(time_s_));
  }

  const core::SpinEvent& spin_;
  const core::Pose& T_map_odom_;
  const IntegratorParams& params_;
  const double inverse_;
  core::Pose pose_;
  float time_s_ = -1.0f;
};

template <typename Field>
class RayIntegrator final : public ScanIntegrator<Field> {
 public:
  explicit RayIntegrator(const IntegratorParams& params) : params_(params) {}

  void Integrate(const core::SpinEvent& spin, const core::Pose& T_map_odom, Octree<Field>* map) override {
    stats_ = {};
    masks_.Clear();
    double clock = ThreadCpuMs();
    const double resolution = map->resolution_m();
    SetKept(resolution);
    truncation_voxels_ = params_.truncation_voxels;
    MarkEnds(spin, T_map_odom, resolution);
    for (const VoxelRay& ray : rays_) Trace(ray);
    stats_.hit_ms = ThreadCpuMs() - clock;
    clock = ThreadCpuMs();
    Apply(map);
    stats_.fill_ms = ThreadCpuMs() - clock;
    stats_.rays = spin.scan.size();
  }
  const IntegrationStats& stats() const override { return stats_; }

 private:
  void SetKept(double resolution) {
    keep_all_ = !params_.region_map;
    if (keep_all_) return;
    keep_min_ = VoxelKeyAt(params_.region_map->min, 1.0 / resolution);
    const Vec3 last = (params_.region_map->max / resolution).array().ceil();
    keep_max_ = VoxelKeyAt(last + Vec3::Constant(0.5), 1.0);
  }
  bool Kept(const NodeKey& v) const {
    return keep_all_ || (v.x >= keep_min_.x && v.y >= keep_min_.y && v.z >= keep_min_.z &&
                         v.x < keep_max_.x && v.y < keep_max_.y && v.z < keep_max_.z);
  }

  /// End voxels first: the first ray to end in a voxel is traced, hits before misses.
  void MarkEnds(const core::SpinEvent& spin, const core::Pose& T_map_odom, double resolution) {
    rays_.clear();
    for (const bool hits : {true, false}) {
      ScanRays source(spin, T_map_odom, params_, resolution);
      for (size_t i = 0; i < spin.scan.size(); ++i) {
        const auto ray = source.At(i);
        if (!ray || ray->hit != hits) continue;
        stats_.hits += hits;
        if (!(hits ? masks_.MarkHit(ray->end) : masks_.MarkMissEnd(ray->end))) continue;
        rays_.push_back(*ray);
      }
    }
  }

  /// Voxels from the origin up to the end are free; the end too, where nothing was hit.
  void Trace(const VoxelRay& ray) {
    const Vec3 target = Vec3(ray.end.x, ray.end.y, ray.end.z).array() + 0.5;
    const NodeKey start = VoxelKeyAt(ray.origin, 1.0);
    const Vec3 step = target - ray.origin;
    VoxelWalk<double> walk(ray.origin.data(), step.data(), start);
    const int count =
        std::abs(ray.end.x - start.x) + std::abs(ray.end.y - start.y) + std::abs(ray.end.z - start.z);
    for (int k = 0; k < count; ++k) {
      masks_.MarkFree(walk.voxel());
      walk.Next();
    }
    if (!ray.hit) masks_.MarkFree(ray.end);
    if constexpr (std::is_same_v<Field, TsdfField>) MarkDistances(ray);
  }

  /// Signed distances along the ray, truncated, in the voxels around its end.
  void MarkDistances(const VoxelRay& ray) {
    if (!ray.hit) return;
    const double begin = std::max(0.0, ray.length - truncation_voxels_);
    const Vec3 from = ray.origin + begin * ray.direction;
    VoxelWalk<double> walk(from.data(), ray.direction.data(), VoxelKeyAt(from, 1.0));
    const double per_unit = 32767.0 / TsdfField::kWidestTruncationVoxels;
    for (int k = 0; k < 64; ++k) {
      const NodeKey& v = walk.voxel();
      const double along = (Vec3(v.x + 0.5, v.y + 0.5, v.z + 0.5) - ray.origin).dot(ray.direction);
      const double distance = ray.length - along;
      if (distance < -truncation_voxels_) break;
      masks_.MarkDistance(
          v, static_cast<int16_t>(std::lround(std::min(distance, truncation_voxels_) * per_unit)));
      walk.Next();
    }
  }

  void Apply(Octree<Field>* map) {
    WriteRules rules;
    rules.miss_units = OccupancyField::StepsOf(params_.miss_nats);
    // The surface somewhere in the voxel.
    rules.hit_units = OccupancyField::StepsOf(params_.hit_nats);
    hit_units_ = rules.hit_units + OccupancyField::kPlaces / 2;
    rules.free_distance =
        static_cast<int16_t>(std::lround(truncation_voxels_ * 32767.0 / TsdfField::kWidestTruncationVoxels));
    rules.lossless = params_.lossless;

    map->SetWorkers(params_.threads);
    const auto groups = masks_.ByChunk();
    std::vector<typename Octree<Field>::Chunk*> chunks;
    for (const auto& group : groups) chunks.push_back(map->FindOrCreate(group.chunk));
    ForEachDynamic(params_.threads, groups.size(), [&](size_t i, int worker) {
      BlockWriter<Field> writer(rules, worker, map, chunks[i]);
      for (const uint32_t slot : groups[i].blocks) WriteBlock(slot, *chunks[i], &writer);
      writer.Close();
    });
  }

  void WriteBlock(uint32_t slot, const typename Octree<Field>::Chunk& chunk,
                  BlockWriter<Field>* writer) const {
    RayMasks::Block block = masks_.block(slot);
    const int index = BlockIndex(block.key.x, block.key.y, block.key.z);
    uint64_t any_hit = 0, any_free = 0, all_free = ~uint64_t{0};
    for (int z = 0; z < 8; ++z) {
      const auto layer = static_cast<size_t>(z);
      if (!keep_all_) CutLayer(block.key, z, &block);
      block.free[layer] &= ~block.hit[layer];
      any_hit |= block.hit[layer];
      any_free |= block.free[layer];
      all_free &= block.free[layer];
    }
    const bool evidence = any_hit != 0 || block.distances != 0;
    if (!evidence && any_free == 0) return;
    if (!evidence && ~all_free == 0 && chunk.Kind(index) == BlockKind::kUniform) {
      writer->FreeUniform(static_cast<size_t>(index >> 6), uint64_t{1} << (index & 63));
      return;
    }
    if constexpr (std::is_same_v<Field, OccupancyField>) {
      int8_t delta[kBlockVoxels] = {};
      for (size_t z = 0; z < 8; ++z) {
        for (uint64_t bits = block.hit[z]; bits != 0; bits &= bits - 1) {
          delta[64 * z + static_cast<size_t>(__builtin_ctzll(bits))] = static_cast<int8_t>(hit_units_);
        }
      }
      writer->UpdateFine(index, block.free, {}, any_hit != 0 ? delta : nullptr);
    } else {
      std::array<int16_t, kBlockVoxels> measured;
      if (block.distances != 0) {
        measured = masks_.distances(block.distances);
        for (int i = 0; !keep_all_ && i < kBlockVoxels; ++i) {
          const NodeKey v{8 * block.key.x + (i & 7), 8 * block.key.y + (i >> 3 & 7),
                          8 * block.key.z + (i >> 6)};
          if (!Kept(v)) measured[static_cast<size_t>(i)] = kNoDistance;
        }
      }
      writer->UpdateFine(index, block.free, {}, block.distances != 0 ? measured.data() : nullptr);
    }
  }

  void CutLayer(const NodeKey& key, int z, RayMasks::Block* block) const {
    uint64_t kept = 0;
    for (int i = 0; i < 64; ++i) {
      kept |= static_cast<uint64_t>(Kept({8 * key.x + (i & 7), 8 * key.y + (i >> 3), 8 * key.z + z})) << i;
    }
    block->free[z] &= kept;
    block->hit[z] &= kept;
  }

  const IntegratorParams params_;
  RayMasks masks_;
  std::vector<VoxelRay> rays_;
  NodeKey keep_min_, keep_max_;
  bool keep_all_ = true;
  double truncation_voxels_ = 3.0;
  int hit_units_ = 1;
  IntegrationStats stats_;
};

}  // namespace

template <typename Field>
std::unique_ptr<ScanIntegrator<Field>> MakeRayIntegrator(const IntegratorParams& params) {
  return std::make_unique<RayIntegrator<Field>>(params);
}

template std::unique_ptr<ScanIntegrator<OccupancyField>> MakeRayIntegrator(const IntegratorParams&);
template std::unique_ptr<ScanIntegrator<TsdfField>> MakeRayIntegrator(const IntegratorParams&);

}  // namespace atlas::mapping
