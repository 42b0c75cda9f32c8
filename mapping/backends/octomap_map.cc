// The OctoMap library as a mapper backend: `mapper.name: octomap`.
//
// OctoMap's own tree, of the setup's box where it has one, updated as the revolutions come, a revolution an
// update of OctoMap's discretised kind: one ray per end voxel, to that voxel's centre, each from its own
// sensor position; every voxel changes once, hits before misses. Rays that pass through the box are cut
// where they leave it. Views read the tree.
#include "mapping/backends/builders.h"

#include <sstream>

#include "core/files.h"
#include "mapping/backends/octomap_view.h"
#include "mapping/cloud/undistort.h"
#include "mapping/copy_on_write.h"
#include "mapping/octree/voxel_ray.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

octomap::point3d PointOf(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

octomap::OcTree TreeFor(const MapperParams& params) {
  octomap::OcTree tree(params.resolution_m);
  tree.setProbHit(params.hit_probability);
  tree.setProbMiss(params.miss_probability);
  tree.setClampingThresMin(params.clamp_min);
  tree.setClampingThresMax(params.clamp_max);
  return tree;
}

class OctomapMap final : public Map {
 public:
  OctomapMap(const MapperParams& params, const MapSetup& setup)
      : params_(params), keep_(setup.keep_map), contents_({TreeFor(params), {}}) {
    if (keep_) range_ = VoxelsOf(*keep_, params.resolution_m);
    if (setup.behind_surface) contents_.Write().behind.emplace(params.resolution_m, params.behind_surface_m);
  }

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    Undistort(*spin.spin, spin.T_map_odom(poses), &rays_);
    OctomapContents& contents = contents_.Write();
    Insert(rays_, &contents.tree);
    if (contents.behind) contents.behind->Mark(rays_, params_.integrator.max_range_m);
  }

  std::shared_ptr<const MapView> Snapshot() const override {
    return std::make_shared<OctomapView>(contents_.Share());
  }

  size_t Bytes() const override {
    const OctomapContents& contents = contents_.Read();
    return contents.tree.memoryUsage() + (contents.behind ? contents.behind->Bytes() : 0);
  }

  std::string Save(const std::filesystem::path& directory) const override {
    std::ostringstream out;
    contents_.Read().tree.writeBinaryConst(out);
    core::WriteFileAtomically(directory / "map.bt", out.str());
    return "map.bt";
  }

 private:
  bool Keeps(const octomap::OcTreeKey& key) const {
    if (!keep_) return true;
    const int32_t x = key[0] - kOctomapZero, y = key[1] - kOctomapZero, z = key[2] - kOctomapZero;
    return x >= range_.first.x && y >= range_.first.y && z >= range_.first.z && x <= range_.last.x &&
           y <= range_.last.y && z <= range_.last.z;
  }

  /// One revolution into the tree (as OccupancyOcTreeBase::insertPointCloud, discretised, does for rays of
  /// one origin).
  void Insert(const UndistortedSpin& spin, octomap::OcTree* tree) {
    hit_.clear();
    passed_.clear();
    ends_.clear();
    const auto max_range_m = static_cast<float>(params_.integrator.max_range_m);
    for (const MapRay& ray : spin.hits) {
      AddRay(ray, static_cast<double>(std::min(ray.range_m, max_range_m)), *tree);
      if (ray.range_m <= max_range_m) AddHit(ray, *tree);
    }
    if (params_.integrator.void_rays == "clear") {
      for (const MapRay& ray : spin.voids) AddRay(ray, params_.integrator.void_range_m, *tree);
    }
    for (const octomap::OcTreeKey& key : passed_) {
      if (hit_.count(key) == 0) tree->updateNode(key, false);
    }
    for (const octomap::OcTreeKey& key : hit_) tree->updateNode(key, true);
  }

  void AddHit(const MapRay& ray, const octomap::OcTree& tree) {
    const Vec3 direction = ray.direction_map.cast<double>();
    const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
    const octomap::OcTreeKey key = tree.coordToKey(PointOf(end));
    if (Keeps(key)) hit_.insert(key);
  }

  /// Free evidence along the ray, which ends at `range_m` or in the first voxel outside the box.
  void AddRay(const MapRay& ray, double range_m, const octomap::OcTree& tree) {
    const Vec3 origin = ray.origin_map.cast<double>(), direction = ray.direction_map.cast<double>();
    double end_m = range_m;
    if (keep_) {
      const auto inside = keep_->Clip(origin, direction);
      if (!inside || inside->first >= range_m) return;
      end_m = std::min(range_m, inside->second + 0.5 * params_.resolution_m);
    }
    const octomap::OcTreeKey end = tree.coordToKey(PointOf(origin + end_m * direction));
    if (!ends_.insert(end).second) return;
    if (!tree.computeRayKeys(PointOf(origin), tree.keyToCoord(end), keys_)) return;
    for (const octomap::OcTreeKey& key : keys_) {
      if (Keeps(key)) passed_.insert(key);
    }
  }

  MapperParams params_;
  std::optional<core::Box3> keep_;
  VoxelRange range_;  ///< of keep_
  CopyOnWrite<OctomapContents> contents_;
  UndistortedSpin rays_;
  octomap::KeySet hit_, passed_, ends_;  ///< of one revolution
  octomap::KeyRay keys_;
};

}  // namespace

std::unique_ptr<Map> BuildOctomapMap(const MapperParams& params, const MapSetup& setup) {
  return std::make_unique<OctomapMap>(params, setup);
}

}  // namespace atlas::mapping
