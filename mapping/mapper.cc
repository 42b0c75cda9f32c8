#include "mapping/mapper.h"

#include "core/errors.h"
#include "mapping/backends/octomap_mapper.h"
#include "mapping/backends/se_atlas_mapper.h"

namespace atlas::mapping {

void MapperParams::Visit(core::ParamVisitor& v) {
  std::vector<std::string> names;
  for (const CatalogEntry& entry : Catalog()) names.push_back(entry.name);
  v.Field("name", &name, {.choices = names, .doc = "backend that holds the map"});
  v.Field("resolution_m", &resolution_m,
          {.unit = "m", .min = 0.02, .max = 0.5, .doc = "edge of the smallest voxel"});
  v.Field("region_margin_m", &region_margin_m,
          {.unit = "m", .min = 0.1, .max = 5.0, .doc = "the map is kept in the object box grown by this"});
  v.Field("max_range_m", &max_range_m,
          {.unit = "m", .min = 1.0, .max = 200.0, .doc = "longer returns are free evidence up to here"});
  v.Field(
      "void_rays", &void_rays,
      {.choices = {"clear", "ignore"}, .doc = "rays without return: free space, or nothing (thesis 3.4.2)"});
  v.Field("void_range_m", &void_range_m,
          {.unit = "m", .min = 0.0, .max = 200.0, .doc = "a ray without return is trusted as free this far"});
  v.Field(
      "downsample_m", &downsample_m,
      {.unit = "m", .min = 0.001, .max = 0.02, .doc = "sweep filter: at most one point a cell of this size"});
  v.Field("hit_probability", &hit_probability, {.min = 0.51, .max = 0.99, .doc = "P(occupied | hit)"});
  v.Field("miss_probability", &miss_probability, {.min = 0.01, .max = 0.49, .doc = "P(occupied | miss)"});
  v.Field("clamp_min", &clamp_min, {.min = 0.0001, .max = 0.19, .doc = "lowest probability kept"});
  v.Field("clamp_max", &clamp_max, {.min = 0.81, .max = 0.9999, .doc = "highest probability kept"});
  v.Field("behind_surface_m", &behind_surface_m,
          {.unit = "m", .min = 0.05, .max = 1.0, .doc = "d_occ of the proximity count gain"});
}

const std::vector<CatalogEntry>& Catalog() {
  static const std::vector<CatalogEntry> kCatalog = {
#define X(name, builder, doc) {name, doc, builder},
#include "mapping/catalog.inc"
#undef X
  };
  return kCatalog;
}

std::unique_ptr<Mapper> MakeMapper(const MapperParams& params, const core::Box3& object_box,
                                   const std::optional<core::LidarModel>& lidar) {
  std::vector<std::string> names;
  for (const CatalogEntry& entry : Catalog()) {
    if (entry.name == params.name) return entry.build(params, object_box, lidar);
    names.push_back(entry.name);
  }
  throw core::InputError(core::UnknownName("mapper", params.name, names));
}

}  // namespace atlas::mapping
