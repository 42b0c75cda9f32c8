// The mapper seam: anchored revolutions in, an occupancy view out.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/keyframe.h"
#include "core/lidar_model.h"
#include "core/params.h"
#include "mapping/integrator/integrator.h"
#include "mapping/occupancy_view.h"

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
  /// What rays say, for all; the rest is se_atlas's. Sweeps come from near by, and so the defaults are others
  /// than those of `atlas map`.
  IntegratorParams integrator = SweepDefaults();
  void Visit(core::ParamVisitor& v);

  static IntegratorParams SweepDefaults();
};

class Mapper {
 public:
  virtual ~Mapper() = default;
  /// Integrates one revolution, where `poses` puts it.
  virtual void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) = 0;
  /// Up to date with the last Integrate(). Between two calls of Integrate(), view(), queries on it and
  /// MapBytes() may be called by several threads at a time.
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

/// Where the map is kept: the object box grown by region_margin_m, out to whole voxels.
core::Box3 RegionOf(const MapperParams& params, const core::Box3& object_box);

}  // namespace atlas::mapping
