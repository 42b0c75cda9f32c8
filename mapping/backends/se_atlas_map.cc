// SE-Atlas as a map: `mapper.name: se_atlas`.
//
// A multi-resolution occupancy octree, fed revolution by revolution with per-ray poses through the cones of
// the beam table that the setup's LiDAR tells, ray by ray where it is absent.
#include "mapping/backends/builders.h"

#include "mapping/cloud/undistort.h"
#include "mapping/copy_on_write.h"
#include "mapping/integrator/integrator.h"
#include "mapping/integrator/occupancy_states.h"
#include "mapping/io/map_file.h"
#include "mapping/octree/octree_view.h"

namespace atlas::mapping {
namespace {

using Field = OccupancyField;

IntegratorParams IntegratorOf(const MapperParams& params, const MapSetup& setup) {
  IntegratorParams integrator = params.integrator;
  integrator.region_map = setup.keep_map;
  return integrator;
}

class SeAtlasMap final : public Map {
 public:
  SeAtlasMap(const MapperParams& params, const MapSetup& setup)
      : params_(params),
        integrator_(MakeIntegrator<Field>(IntegratorOf(params, setup), setup.lidar)),
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
