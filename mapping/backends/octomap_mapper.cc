#include "mapping/backends/octomap_mapper.h"

#include <octomap/OcTree.h>

#include <sstream>

#include "core/files.h"
#include "mapping/backends/behind_surface.h"
#include "mapping/backends/octomap_view.h"
#include "mapping/backends/on_demand.h"
#include "mapping/cloud/undistort.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

octomap::point3d PointOf(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

class OctomapMapper : public Mapper {
 public:
  OctomapMapper(const MapperParams& params, const core::Box3& object_box)
      : params_(params),
        tree_(params.resolution_m),
        view_(tree_, GridFrame(object_box.Inflated(params.region_margin_m), params.resolution_m)) {
    tree_.setProbHit(params.hit_probability);
    tree_.setProbMiss(params.miss_probability);
    tree_.setClampingThresMin(params.clamp_min);
    tree_.setClampingThresMax(params.clamp_max);
  }

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    Undistort(*spin.spin, spin.T_map_odom(poses), &rays_);
    Insert(rays_);
    index_.Request();
  }

  const OccupancyView& view() const override {
    index_.Ensure([this] { view_.FinishUpdate(); });
    return view_;
  }

  size_t MapBytes() const override {
    view();
    return tree_.memoryUsage() + view_.Bytes();
  }

  std::string Save(const std::filesystem::path& directory) const override {
    std::ostringstream out;
    tree_.writeBinaryConst(out);
    core::WriteFileAtomically(directory / "map.bt", out.str());
    return "map.bt";
  }

 private:
  /// One revolution into the tree (as OccupancyOcTreeBase::insertPointCloud, discretised, does for rays of
  /// one origin).
  void Insert(const UndistortedSpin& spin) {
    hit_.clear();
    passed_.clear();
    ends_.clear();
    const auto max_range_m = static_cast<float>(params_.integrator.max_range_m);
    for (const MapRay& ray : spin.hits) {
      AddRay(ray, static_cast<double>(std::min(ray.range_m, max_range_m)));
      if (ray.range_m <= max_range_m) AddHit(ray);
    }
    if (params_.integrator.void_rays == "clear") {
      for (const MapRay& ray : spin.voids) AddRay(ray, params_.integrator.void_range_m);
    }
    for (const octomap::OcTreeKey& key : passed_) {
      if (hit_.count(key) == 0) tree_.updateNode(key, false);
    }
    for (const octomap::OcTreeKey& key : hit_) tree_.updateNode(key, true);
  }

  void AddHit(const MapRay& ray) {
    const Vec3 direction = ray.direction_map.cast<double>();
    const Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
    const octomap::OcTreeKey key = tree_.coordToKey(PointOf(end));
    if (!view_.Holds(key) || !hit_.insert(key).second) return;
    MarkBehindSurface(view_.frame(), end, direction, params_.behind_surface_m,
                      [this](size_t index, int value) { view_.SetBehindSurface(index, value); });
  }

  /// Free evidence along the ray, which ends at `range_m` or in the first voxel outside the region.
  void AddRay(const MapRay& ray, double range_m) {
    const Vec3 origin = ray.origin_map.cast<double>(), direction = ray.direction_map.cast<double>();
    const auto inside = view_.region().Clip(origin, direction);
    if (!inside || inside->first >= range_m) return;
    const double end_m = std::min(range_m, inside->second + 0.5 * params_.resolution_m);
    const octomap::OcTreeKey end = tree_.coordToKey(PointOf(origin + end_m * direction));
    if (!ends_.insert(end).second) return;
    if (!tree_.computeRayKeys(PointOf(origin), tree_.keyToCoord(end), keys_)) return;
    for (const octomap::OcTreeKey& key : keys_) {
      if (view_.Holds(key)) passed_.insert(key);
    }
  }

  MapperParams params_;
  octomap::OcTree tree_;
  OnDemand index_;  ///< of the view, built where it is asked for
  mutable OctomapView view_;
  UndistortedSpin rays_;
  octomap::KeySet hit_, passed_, ends_;  ///< of one revolution
  octomap::KeyRay keys_;
};

}  // namespace

std::unique_ptr<Mapper> BuildOctomapMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>&) {
  return std::make_unique<OctomapMapper>(params, object_box);
}

}  // namespace atlas::mapping
