#include "experiments/mapping_tools/offline_map.h"

#include <cmath>

#include "mapping/octree/queries.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;
using mapping::OccupancyField;
using mapping::Octree;
using mapping::ScanIntegrator;
using mapping::TsdfField;

template <typename Field>
MapVolume VolumeOfTree(const Octree<Field>& map) {
  uint64_t free = 0, occupied = 0;  // voxels
  mapping::ForEachCell(map, [&](const mapping::NodeKey&, int level, typename Field::Value value) {
    (Field::Occupied(value) ? occupied : free) += uint64_t{1} << (3 * level);
  });
  const double voxel_m3 = std::pow(map.resolution_m(), 3);
  return {static_cast<double>(free) * voxel_m3, static_cast<double>(occupied) * voxel_m3};
}

mapping::AnyOctree EmptyMap(const OfflineMapParams& params) {
  if (params.field == TsdfField::kName) return mapping::TsdfOctree(params.resolution_m);
  return mapping::OccupancyOctree(params.resolution_m);
}

using AnyIntegrator =
    std::variant<std::unique_ptr<ScanIntegrator<OccupancyField>>, std::unique_ptr<ScanIntegrator<TsdfField>>>;

template <typename Field>
std::unique_ptr<ScanIntegrator<Field>> IntegratorFor(const OfflineMapParams& params,
                                                     const std::optional<core::LidarModel>& lidar) {
  return lidar ? mapping::MakeConeIntegrator<Field>(params.integrator, *lidar)
               : mapping::MakeRayIntegrator<Field>(params.integrator);
}

AnyIntegrator MakeIntegrator(const OfflineMapParams& params, const std::optional<core::LidarModel>& lidar) {
  if (params.field == TsdfField::kName) return IntegratorFor<TsdfField>(params, lidar);
  return IntegratorFor<OccupancyField>(params, lidar);
}

double CloudSpacing(const OfflineMapParams& params) {
  return params.cloud_spacing_m > 0.0 ? params.cloud_spacing_m : params.resolution_m;
}

}  // namespace

void OfflineMapParams::Visit(core::ParamVisitor& v) {
  v.Field("field", &field,
          {.choices = {"occupancy", "tsdf"}, .doc = "what a voxel holds: log-odds or a signed distance"});
  mapping::VisitResolution(&resolution_m, v);
  v.Field("local_radius_m", &local_radius_m,
          {.unit = "m", .min = 0.0, .max = 1000.0, .doc = "rolling map cropped to this; 0: keep all"});
  v.Field("cloud_spacing_m", &cloud_spacing_m,
          {.unit = "m", .min = 0.0, .max = 10.0, .doc = "one cloud point a cell of this; 0: resolution"});
  core::AbsentFields absent(&v, "mapper.field = " + field);
  const bool tsdf = field == TsdfField::kName;
  integrator.VisitRays(v);
  integrator.VisitFilling(v);
  integrator.VisitOccupancy(tsdf ? static_cast<core::ParamVisitor&>(absent) : v);
  integrator.VisitTsdf(tsdf ? v : absent);
}

void CloudBuilder::Add(const core::SpinEvent& spin, const core::Pose& T_map_odom) {
  const core::LidarScan& scan = spin.scan;
  const bool moving = spin.T_odom_lidar.poses().size() > 1 && scan.time_s.size() == scan.size();
  core::Pose T = T_map_odom * spin.T_odom_lidar.At(scan.stamp_s);
  float posed_at_s = 0.0f;  // rays of one firing share a pose
  for (size_t i = 0; i < scan.size(); ++i) {
    if (scan.kind[i] != core::ReturnKind::kHit || scan.range_m[i] > max_range_m_) continue;
    if (moving && scan.time_s[i] != posed_at_s) {
      posed_at_s = scan.time_s[i];
      T = T_map_odom * spin.T_odom_lidar.At(scan.stamp_s + static_cast<double>(posed_at_s));
    }
    const Vec3 p = T * (scan.range_m[i] * scan.direction_lidar[i]).cast<double>();
    if (filter_.Insert(p.cast<float>())) cloud_.points.push_back(p.cast<float>());
  }
}

core::PointCloud CloudBuilder::Within(const Vec3& center, double radius_m) const {
  core::PointCloud cloud;
  for (const Vec3f& p : cloud_.points) {
    if ((p.cast<double>() - center).norm() <= radius_m) cloud.points.push_back(p);
  }
  return cloud;
}

MapVolume VolumeOf(const mapping::AnyOctree& map) {
  return std::visit([](const auto& tree) { return VolumeOfTree(tree); }, map);
}

template <typename Field>
void CropAround(const Vec3& center, double radius_m, Octree<Field>* map) {
  const double side_m = mapping::kChunkSide * map->resolution_m();
  std::vector<mapping::NodeKey> far;
  for (const auto* chunk : map->Chunks()) {
    const Vec3 corner = side_m * Vec3(chunk->key.x, chunk->key.y, chunk->key.z);
    const core::Box3 box{corner, corner.array() + side_m};
    if (box.DistanceTo(center) > radius_m) far.push_back(chunk->key);
  }
  for (const mapping::NodeKey& key : far) map->Erase(key);
}
template void CropAround(const Vec3&, double, mapping::OccupancyOctree*);
template void CropAround(const Vec3&, double, mapping::TsdfOctree*);

struct OfflineMapper::Impl {
  Impl(const OfflineMapParams& p, const std::optional<core::LidarModel>& lidar)
      : params(p),
        map(EmptyMap(p)),
        integrator(MakeIntegrator(p, lidar)),
        cloud(CloudSpacing(p), p.integrator.max_range_m) {}

  OfflineMapParams params;
  mapping::AnyOctree map;
  AnyIntegrator integrator;
  CloudBuilder cloud;
  Vec3 center = Vec3::Zero();  // of the rolling map
};

OfflineMapper::OfflineMapper(const OfflineMapParams& params, const std::optional<core::LidarModel>& lidar)
    : impl_(std::make_unique<Impl>(params, lidar)) {}
OfflineMapper::~OfflineMapper() = default;

void OfflineMapper::Add(const core::SpinEvent& spin, const core::Pose& T_map_odom) {
  impl_->center = (T_map_odom * spin.T_odom_lidar.At(spin.scan.stamp_s)).translation();
  const double radius_m = impl_->params.local_radius_m;
  std::visit(
      [&](auto& tree) {
        using Field = std::conditional_t<std::is_same_v<std::decay_t<decltype(tree)>, mapping::TsdfOctree>,
                                         TsdfField, OccupancyField>;
        std::get<std::unique_ptr<ScanIntegrator<Field>>>(impl_->integrator)
            ->Integrate(spin, T_map_odom, &tree);
        if (radius_m > 0.0) CropAround(impl_->center, radius_m, &tree);
      },
      impl_->map);
  impl_->cloud.Add(spin, T_map_odom);
}

const mapping::AnyOctree& OfflineMapper::map() const {
  return impl_->map;
}

size_t OfflineMapper::MapBytes() const {
  return std::visit([](const auto& tree) { return tree.Bytes(); }, impl_->map);
}

core::PointCloud OfflineMapper::Cloud() const {
  const double radius_m = impl_->params.local_radius_m;
  return radius_m > 0.0 ? impl_->cloud.Within(impl_->center, radius_m) : impl_->cloud.cloud();
}

const mapping::IntegrationStats& OfflineMapper::stats() const {
  return std::visit(
      [](const auto& integrator) -> const mapping::IntegrationStats& { return integrator->stats(); },
      impl_->integrator);
}

}  // namespace atlas::experiments
