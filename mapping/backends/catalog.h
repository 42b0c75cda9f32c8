// Maps by name, and what they are built from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/params.h"
#include "mapping/atlas/atlas_params.h"
#include "mapping/integrator/integrator.h"
#include "mapping/map.h"

namespace atlas::mapping {

/// Those that a backend has no use for are not shown with it, and refused.
struct MapperParams {
  std::string name = "se_atlas";
  double resolution_m = 0.05;
  double region_margin_m = 0.2;  ///< the map is kept in the object box grown by this
  double downsample_m = 0.015;   ///< of a scan's cloud: at most one point a cell of this size
  // octomap, dense_grid:
  double hit_probability = 0.7;
  double miss_probability = 0.4;
  double clamp_min = 0.12;
  double clamp_max = 0.97;
  double behind_surface_m = 0.3;  ///< d_occ of the proximity count gain
  /// The measurement model of rays, for all; the rest is se_atlas's and atlas's. Sweeps come from near by,
  /// and so the defaults are others than those of `atlas map`.
  IntegratorParams integrator = SweepDefaults();
  AtlasParams atlas;  ///< atlas
  void Visit(core::ParamVisitor& v);

  static IntegratorParams SweepDefaults();
};

struct CatalogEntry {
  std::string name;
  std::string doc;
  std::unique_ptr<Map> (*build)(const MapperParams&, const MapSetup& setup);
};
const std::vector<CatalogEntry>& Catalog();

/// @throws InputError for an unknown name.
std::unique_ptr<Map> MakeMap(const MapperParams& params, const MapSetup& setup);

/// An object's box grown by region_margin_m, out to whole voxels: what a map of the object keeps.
core::Box3 RegionOf(const MapperParams& params, const core::Box3& object_box);

}  // namespace atlas::mapping
