#include "mapping/backends/catalog.h"

#include "core/catalog.h"
#include "mapping/backends/builders.h"

namespace atlas::mapping {

namespace {

/// OctoMap's inverse sensor model (Hornung et al. 2013).
void VisitUpdateRule(MapperParams* p, core::ParamVisitor& v) {
  v.Field("hit_probability", &p->hit_probability, {.min = 0.51, .max = 0.99, .doc = "P(occupied | hit)"});
  v.Field("miss_probability", &p->miss_probability, {.min = 0.01, .max = 0.49, .doc = "P(occupied | miss)"});
  v.Field("clamp_min", &p->clamp_min, {.min = 0.0001, .max = 0.19, .doc = "lowest probability kept"});
  v.Field("clamp_max", &p->clamp_max, {.min = 0.81, .max = 0.9999, .doc = "highest probability kept"});
}

}  // namespace

IntegratorParams MapperParams::SweepDefaults() {
  IntegratorParams integrator;
  integrator.max_range_m = 20.0;
  // From near by, what is held without a return is cleared sooner than from afar.
  integrator.near_nats = 0.2;
  // Beams that skim a surface return far apart: what lies between is left for another view.
  integrator.skim_cosine = 0.5;
  // Behind a surface that ends, evidence would hide what the next view is to find: behind_min_voxels alone.
  integrator.behind_max_m = 0.0;
  return integrator;
}

void MapperParams::Visit(core::ParamVisitor& v) {
  v.Field("name", &name, {.choices = core::NamesOf(Catalog()), .doc = "backend that holds the map"});
  VisitResolution(&resolution_m, v);
  v.Field("region_margin_m", &region_margin_m,
          {.unit = "m", .min = 0.1, .max = 5.0, .doc = "the map is kept in the object box grown by this"});
  v.Field(
      "downsample_m", &downsample_m,
      {.unit = "m", .min = 0.001, .max = 0.02, .doc = "sweep filter: at most one point a cell of this size"});
  v.Field("behind_surface_m", &behind_surface_m,
          {.unit = "m", .min = 0.05, .max = 1.0, .doc = "d_occ of the proximity count gain"});
  integrator.VisitRays(v);
  core::AbsentFields absent(&v, "mapper.name = " + name);
  core::ParamVisitor& none = absent;
  const bool elastic = name == "atlas", octree = name == "se_atlas" || elastic;
  VisitUpdateRule(this, octree ? none : v);
  integrator.VisitFilling(octree ? v : none);
  integrator.VisitOccupancy(octree ? v : none);
  atlas.Visit(elastic ? v : none);
}

const std::vector<CatalogEntry>& Catalog() {
  static const std::vector<CatalogEntry> kCatalog = {
#define X(name, builder, doc) {name, doc, builder},
#include "mapping/backends/catalog.inc"
#undef X
  };
  return kCatalog;
}

core::Box3 RegionOf(const MapperParams& params, const core::Box3& object_box) {
  const core::Box3 grown = object_box.Inflated(params.region_margin_m);
  const double voxel_m = params.resolution_m;
  return {(grown.min / voxel_m).array().floor() * voxel_m, (grown.max / voxel_m).array().ceil() * voxel_m};
}

std::unique_ptr<Map> MakeMap(const MapperParams& params, const MapSetup& setup) {
  return core::EntryNamed(Catalog(), "mapper", params.name).build(params, setup);
}

}  // namespace atlas::mapping
