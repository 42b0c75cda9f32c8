// SE-Atlas as a map: `mapper.name: se_atlas`.
//
// A multi-resolution occupancy octree, fed revolution by revolution with per-ray poses through the cones of
// the beam table that the setup's LiDAR tells, ray by ray where it is absent.
#include "mapping/backends/builders.h"

#include "mapping/backends/octree_view.h"
#include "mapping/cloud/undistort.h"
#include "mapping/copy_on_write.h"
#include "mapping/integrator/integrator.h"
#include "mapping/io/map_file.h"

namespace atlas::mapping {
namespace {

using Field = OccupancyField;

/// The planner calls a voxel occupied from 0.75 miss_nats on: the least that Eq. 4.2 gives behind a near
/// surface.
constexpr double kSurfaceShare = 0.75;

/// Free nodes keep the least that is known of their voxels, and cones claim free space only where no beam
/// contradicts, so one scan's miss decides free, and as much evidence as a scan gives of a surface decides
/// occupied (thesis 4.5.2: negative is free, positive occupied). Voxels between have seen both.
StateLogOdds StatesOf(const IntegratorParams& params) {
  const double miss = Field::kNatsPerUnit * Field::StepsOf(params.miss_nats);
  return {-miss, kSurfaceShare * miss};
}

IntegratorParams IntegratorOf(const MapperParams& params, const MapSetup& setup) {
  IntegratorParams integrator = params.integrator;
  integrator.region_map = setup.keep_map;
  return integrator;
}

std::unique_ptr<ScanIntegrator<Field>> MakeIntegrator(const IntegratorParams& params, const MapSetup& setup) {
  return setup.lidar ? MakeConeIntegrator<Field>(params, *setup.lidar) : MakeRayIntegrator<Field>(params);
}

class SeAtlasMap final : public Map {
 public:
  SeAtlasMap(const MapperParams& params, const MapSetup& setup)
      : params_(params),
        integrator_(MakeIntegrator(IntegratorOf(params, setup), setup)),
        contents_({OccupancyOctree(params.resolution_m), {}}) {
    if (setup.behind_surface) contents_.Write().behind.emplace(params.resolution_m, params.behind_surface_m);
  }

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    const core::Pose T_map_odom = spin.T_map_odom(poses);
    OctreeContents& contents = contents_.Write();
    integrator_->Integrate(*spin.spin, T_map_odom, &contents.tree);
    if (!contents.behind) return;
    UndistortHits(*spin.spin, T_map_odom, &rays_);
    contents.behind->Mark(rays_, params_.integrator.max_range_m);
  }

  std::shared_ptr<const MapView> Snapshot() const override {
    return std::make_shared<OctreeView>(contents_.Share(), StatesOf(params_.integrator));
  }

  size_t Bytes() const override {
    const OctreeContents& contents = contents_.Read();
    return contents.tree.Bytes() + (contents.behind ? contents.behind->Bytes() : 0);
  }

  std::string Save(const std::filesystem::path& directory) const override {
    WriteMap(directory / "map.atlas", contents_.Read().tree);
    return "map.atlas";
  }

 private:
  MapperParams params_;
  std::unique_ptr<ScanIntegrator<Field>> integrator_;
  CopyOnWrite<OctreeContents> contents_;
  UndistortedSpin rays_;
};

}  // namespace

std::unique_ptr<Map> BuildSeAtlasMap(const MapperParams& params, const MapSetup& setup) {
  return std::make_unique<SeAtlasMap>(params, setup);
}

}  // namespace atlas::mapping
