// The mapper seam: sweeps in, an occupancy view out.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/lidar_model.h"
#include "core/mesh.h"
#include "core/params.h"
#include "core/sensor_events.h"
#include "mapping/occupancy_view.h"

namespace atlas::mapping {

struct MapperParams {
  std::string name = "se_atlas";
  double resolution_m = 0.05;
  double region_margin_m = 0.2;     ///< the map is kept in the object box grown by this
  double max_range_m = 20.0;        ///< longer returns count as misses along the trusted part of the ray
  std::string void_rays = "clear";  ///< clear (free to void_range_m) | ignore (the thesis's filtered clouds)
  double void_range_m = 20.0;       ///< a void ray is trusted this far
  double downsample_m = 0.015;      ///< filter: at most one point a cell of this size
  double hit_probability = 0.7;
  double miss_probability = 0.4;
  double clamp_min = 0.12;
  double clamp_max = 0.97;
  double behind_surface_m = 0.3;  ///< d_occ of the proximity count gain
  void Visit(core::ParamVisitor& v);
};

class Mapper {
 public:
  virtual ~Mapper() = default;
  /// Integrates one sweep, spin by spin. Returns its filtered cloud in the map frame (thesis 3.3).
  virtual core::PointCloud Integrate(const core::Sweep& sweep) = 0;
  /// Up to date with the last Integrate(). Queries on it and MapBytes() may run side by side.
  virtual const OccupancyView& view() const = 0;
  virtual size_t MapBytes() const = 0;
  /// Writes the map in the backend's own format; returns the file's name.
  virtual std::string Save(const std::filesystem::path& directory) const = 0;
};

struct CatalogEntry {
  std::string name;
  std::string doc;
  std::unique_ptr<Mapper> (*build)(const MapperParams&, const core::Box3& object_box,
                                   const std::optional<core::LidarModel>& lidar);
};
const std::vector<CatalogEntry>& Catalog();

/// `lidar` made the spins that the mapper will see; absent where that is not known. @throws InputError for an
/// unknown name.
std::unique_ptr<Mapper> MakeMapper(const MapperParams& params, const core::Box3& object_box,
                                   const std::optional<core::LidarModel>& lidar = {});

/// Undistorts the sweep: hits inside `region_map`, in the map frame by per-ray time (odom first, then map;
/// thesis 3.3), isolated returns removed, at most one point a cell of `spacing_m`.
core::PointCloud AccumulateSweep(const core::Sweep& sweep, const core::Box3& region_map, double max_range_m,
                                 double spacing_m);

}  // namespace atlas::mapping
