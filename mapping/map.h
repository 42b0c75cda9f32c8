// The map seam: anchored revolutions in, snapshots out.
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
#include "mapping/map_view.h"

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

/// What a map is made for.
struct MapSetup {
  std::optional<core::LidarModel> lidar = {};  ///< that the spins come from; absent where that is not known
  /// Nothing is kept outside; absent: all is kept.
  std::optional<core::Box3> keep_map = {};
  bool behind_surface = false;  ///< keep how far behind a hit unmeasured voxels lie (proximity count)
};

class Map {
 public:
  virtual ~Map() = default;
  /// Integrates one revolution, where `poses` puts it.
  virtual void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) = 0;
  /// The map as it is, for as long as it is held. A snapshot costs nothing while it is let go before the next
  /// Integrate(), and a copy of the map where it is not.
  virtual std::shared_ptr<const MapView> Snapshot() const = 0;
  virtual size_t Bytes() const = 0;
  /// Writes the map in the backend's own format; returns the file's name.
  virtual std::string Save(const std::filesystem::path& directory) const = 0;
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
