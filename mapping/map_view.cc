#include "mapping/map_view.h"

namespace atlas::mapping {

std::vector<core::Vec3f> OccupiedCenters(const MapView& map, const core::Box3& box_map) {
  std::vector<core::Vec3f> centers;
  map.ForEachOccupied(box_map, [&centers](const core::Vec3f& center) { centers.push_back(center); });
  return centers;
}

}  // namespace atlas::mapping
