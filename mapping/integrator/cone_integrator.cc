#include <algorithm>
#include <bit>
#include <cmath>

#include "core/errors.h"
#include "mapping/integrator/dynamic_loop.h"
#include "mapping/integrator/free_space/scan_memory.h"
#include "mapping/integrator/integrator.h"
#include "mapping/integrator/surface/hit_scatter.h"
#include "mapping/integrator/write/chunk_fill.h"

namespace atlas::mapping {
namespace {

template <typename Field>
class ConeIntegrator final : public ScanIntegrator<Field> {
 public:
  ConeIntegrator(const IntegratorParams& params, const core::LidarModel& lidar)
      : params_(params), grid_(MakeBeamGrid(lidar)), image_(grid_), surface_(image_), tables_(image_) {
    tables_.pierce_voxels = static_cast<float>(params.pierce_voxels);
  }

  void Integrate(const core::SpinEvent& spin, const core::Pose& T_map_odom, Octree<Field>* map) override {
    Check(spin.scan);
    stats_ = {};
    double clock = ThreadCpuMs();
    const auto lap = [&clock] {
      const double before = clock;
      clock = ThreadCpuMs();
      return clock - before;
    };
    const double resolution = map->resolution_m();
    ImageOptions options = OptionsFor(resolution);
    PosesOfScan(spin, params_.motion_aware, &poses_);
    const core::Pose T_map_lidar = T_map_odom * poses_.T_odom_mid;
    KeepColumns(params_.region_map, T_map_lidar, &image_);
    Remap(spin.scan, options);
    // At the farthest return beams are apart_m apart; wider cells are never used, so their tables are
    // skipped.
    const double apart_m = static_cast<double>(image_.reach_m) * grid_.min_pitch_rad;
    while (options.max_scale > 1 && options.max_scale * resolution > apart_m) options.max_scale /= 2;
    FindPlanes(T_map_lidar.linear(), options, image_, {&surface_, &tables_});
    BuildTables(options, surface_, &tables_);
    hits_.Place(image_, T_map_lidar, resolution, &frame_);
    stats_.image_ms = lap();

    FillContext context = ContextFor(resolution);
    context.max_scale = options.max_scale;
    map->SetWorkers(params_.threads);
    FindChunks(context);
    // Hits fall into place while blocks are tested.
    ForEachDynamic(params_.threads, work_.size() + 1, [&](size_t i, int) {
      if (i > 0) return TestChunkBlocks(&work_[i - 1]);
      if constexpr (kOccupancy)
        hits_.Scatter(surface_, frame_, SurfaceModel::Of(params_, resolution), context.keep_min,
                      context.keep_max);
    });
    stats_.hit_ms = lap();
    AddTouchedChunks(context);
    Fill(context, map);
    stats_.fill_ms = lap();
    stats_.rays = spin.scan.size();
  }

  const IntegrationStats& stats() const override { return stats_; }

 private:
  static constexpr bool kOccupancy = std::is_same_v<Field, OccupancyField>;

  /// Thesis 4.5.3: rays to where they point from the middle of the scan, then to the cells nearest to them.
  void Remap(const core::LidarScan& scan, const ImageOptions& options) {
    const MemoryLoan loan(scan.size(), &surface_, &tables_, &rays_, &bins_);
    ProjectScan({scan, poses_, options, grid_}, &rays_);
    BinRays(image_, rays_, &bins_);
    MatchCells(rays_, options, &bins_, &image_);
  }

  bool Touched(const ChunkWork& work) const { return kOccupancy && hits_.Touched(work.index) != nullptr; }

  void Check(const core::LidarScan& scan) const {
    const size_t rays = static_cast<size_t>(scan.rows) * static_cast<size_t>(scan.columns);
    if (scan.rows < 1 || scan.columns < 16 || scan.size() != rays || scan.direction_lidar.size() != rays ||
        scan.range_m.size() != rays || (!scan.time_s.empty() && scan.time_s.size() != rays)) {
      throw core::InputError("scan: not organised, or its columns are fewer than 16");
    }
  }

  ImageOptions OptionsFor(double resolution) const {
    ImageOptions o;
    o.resolution_m = static_cast<float>(resolution);
    o.max_range_m = static_cast<float>(params_.max_range_m);
    o.void_range_m = params_.void_rays == "ignore"
                         ? 0.0f
                         : static_cast<float>(std::min(params_.void_range_m, params_.max_range_m));
    o.sigma_min_m = static_cast<float>(params_.sigma_min_m);
    o.lambda_sigma = static_cast<float>(params_.lambda_sigma);
    o.remap_stop_rad = static_cast<float>(params_.remap_stop_rad);
    o.max_scale = static_cast<int>(std::bit_floor(static_cast<unsigned>(params_.max_scale)));
    if (!kOccupancy)
      o.reach_behind_m = static_cast<float>(params_.truncation_voxels * resolution * o.max_scale);
    o.motion_aware = params_.motion_aware;
    o.threads = params_.threads;
    return o;
  }

  FillContext ContextFor(double resolution) const {
    FillContext c;
    c.tables = &tables_;
    c.surface = &surface_;
    c.frame = &frame_;
    c.hits = &hits_;
    c.rules.miss_units = OccupancyField::StepsOf(params_.miss_nats);
    c.rules.hit_units = OccupancyField::StepsOf(params_.hit_nats);
    c.rules.edge_units = OccupancyField::StepsOf(params_.edge_nats);
    c.rules.free_distance = static_cast<int16_t>(
        std::lround(params_.truncation_voxels * resolution / TsdfField::UnitM(resolution)));
    c.rules.lossless = params_.lossless;
    c.truncation_m = static_cast<float>(params_.truncation_voxels * resolution);
    c.distance_unit_m = static_cast<float>(TsdfField::UnitM(resolution));
    const int chunk[3] = {frame_.first_chunk.x, frame_.first_chunk.y, frame_.first_chunk.z};
    int low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = 0;
      high[a] = frame_.chunks[static_cast<size_t>(a)] * kChunkSide;
      if (!params_.region_map) continue;
      const double first = static_cast<double>(chunk[a]) * kChunkSide;
      const auto bound = [&](double v) { return std::clamp(v - first, 0.0, static_cast<double>(high[a])); };
      low[a] = static_cast<int>(bound(std::floor(params_.region_map->min[a] / resolution)));
      high[a] = static_cast<int>(bound(std::ceil(params_.region_map->max[a] / resolution)));
    }
    c.keep_min = {low[0], low[1], low[2]};
    c.keep_max = {high[0], high[1], high[2]};
    return c;
  }

  /// The chunks of the window that the scan may change, 16 tested at a time.
  void FindChunks(const FillContext& context) {
    work_.clear();
    const NodeKey &low = context.keep_min, &high = context.keep_max;
    std::vector<ChunkWork>& group = group_;
    group.clear();
    for (int z = low.z >> 6; z << 6 < high.z; ++z) {
      for (int y = low.y >> 6; y << 6 < high.y; ++y) {
        for (int x = low.x >> 6; x << 6 < high.x; ++x) {
          ChunkWork w;
          w.window = {x, y, z};
          w.index =
              static_cast<size_t>(x) +
              static_cast<size_t>(frame_.chunks[0]) *
                  (static_cast<size_t>(y) + static_cast<size_t>(frame_.chunks[1]) * static_cast<size_t>(z));
          group.push_back(w);
          if (group.size() == 16) TestGroup(context);
        }
      }
    }
    if (!group.empty()) TestGroup(context);
  }

  /// Chunks that bear hits and nothing else.
  void AddTouchedChunks(const FillContext& context) {
    if constexpr (kOccupancy) {
      found_.assign(hits_.chunks(), 0);
      for (const ChunkWork& w : work_) found_[w.index] = 1;
      const auto nx = static_cast<size_t>(frame_.chunks[0]), ny = static_cast<size_t>(frame_.chunks[1]);
      for (size_t i = 0; i < found_.size(); ++i) {
        if (found_[i] != 0 || hits_.Touched(i) == nullptr) continue;
        ChunkWork w;
        w.index = i;
        w.window = {static_cast<int>(i % nx), static_cast<int>(i / nx % ny), static_cast<int>(i / nx / ny)};
        w.cut = !Inside(context, w.window);
        work_.push_back(w);
      }
    }
  }

  void TestGroup(const FillContext& context) {
    float x[16] = {}, y[16] = {}, z[16] = {};
    for (size_t i = 0; i < group_.size(); ++i) {
      x[i] = static_cast<float>(group_[i].window.x * kChunkSide + kChunkSide / 2);
      y[i] = static_cast<float>(group_[i].window.y * kChunkSide + kChunkSide / 2);
      z[i] = static_cast<float>(group_[i].window.z * kChunkSide + kChunkSide / 2);
    }
    const CubeTests tests = TestBoxes(tables_, frame_, x, y, z, kChunkSide / 2);
    for (size_t i = 0; i < group_.size(); ++i) {
      ChunkWork& w = group_[i];
      const bool inside = Inside(context, w.window);
      w.all_full = (tests.full >> i & 1) != 0 && inside;
      w.tested = !w.all_full && ((tests.mixed | tests.full) >> i & 1) != 0;
      w.cut = !inside;
      if (w.all_full || w.tested) work_.push_back(w);
    }
    group_.clear();
  }

  /// Whether a chunk lies wholly in what is kept.
  static bool Inside(const FillContext& context, const NodeKey& chunk) {
    const NodeKey &low = context.keep_min, &high = context.keep_max;
    return chunk.x * kChunkSide >= low.x && (chunk.x + 1) * kChunkSide <= high.x &&
           chunk.y * kChunkSide >= low.y && (chunk.y + 1) * kChunkSide <= high.y &&
           chunk.z * kChunkSide >= low.z && (chunk.z + 1) * kChunkSide <= high.z;
  }

  void TestChunkBlocks(ChunkWork* work) const {
    const NodeKey corner{work->window.x * kChunkSide, work->window.y * kChunkSide,
                         work->window.z * kChunkSide};
    if (work->all_full) {
      work->blocks.full.bits.fill(~uint64_t{0});
    } else if (work->tested) {
      TestBlocks(tables_, frame_, corner, &work->blocks);
    }
  }

  void Fill(const FillContext& context, Octree<Field>* map) {
    chunks_.assign(work_.size(), nullptr);
    for (size_t i = 0; i < work_.size(); ++i) {
      const ChunkWork& w = work_[i];
      if (!w.blocks.mixed.Any() && !w.blocks.full.Any() && !Touched(w)) continue;
      const NodeKey& first = frame_.first_chunk;
      chunks_[i] = map->FindOrCreate({first.x + w.window.x, first.y + w.window.y, first.z + w.window.z});
    }
    ForEachDynamic(params_.threads, work_.size(), [&](size_t i, int worker) {
      if (chunks_[i] != nullptr) FillChunk(context, work_[i], worker, map, chunks_[i]);
    });
  }

  IntegratorParams params_;
  BeamGrid grid_;
  ColumnPoses poses_;
  RayBundle rays_;
  RayBins bins_;
  RangeImage image_;
  SurfaceImage surface_;
  FreeSpaceTables tables_;
  ScanFrame frame_;
  HitScatter hits_;
  std::vector<ChunkWork> work_, group_;
  std::vector<uint8_t> found_;
  std::vector<typename Octree<Field>::Chunk*> chunks_;
  IntegrationStats stats_;
};

}  // namespace

template <typename Field>
std::unique_ptr<ScanIntegrator<Field>> MakeConeIntegrator(const IntegratorParams& params,
                                                          const core::LidarModel& lidar) {
  return std::make_unique<ConeIntegrator<Field>>(params, lidar);
}

template std::unique_ptr<ScanIntegrator<OccupancyField>> MakeConeIntegrator(const IntegratorParams&,
                                                                            const core::LidarModel&);
template std::unique_ptr<ScanIntegrator<TsdfField>> MakeConeIntegrator(const IntegratorParams&,
                                                                       const core::LidarModel&);

}  // namespace atlas::mapping
