#include "experiments/results/map_slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/files.h"

namespace atlas::experiments {

void WriteMapSlice(const std::filesystem::path& folder, const mapping::MapView& map,
                   const core::Box3& box_map, double height_m) {
  const double pixel_m = map.resolution_m();
  const auto pixels = [&](double m) { return std::max(1, static_cast<int>(std::ceil(m / pixel_m - 1e-6))); };
  const int columns = pixels(box_map.Size().x()), rows = pixels(box_map.Size().y());
  std::string pgm = fmt::format("P5\n{} {}\n255\n", columns, rows);
  for (int r = rows - 1; r >= 0; --r) {
    for (int c = 0; c < columns; ++c) {
      const core::Vec3 p(box_map.min.x() + (c + 0.5) * pixel_m, box_map.min.y() + (r + 0.5) * pixel_m,
                         height_m);
      const mapping::CellState state = map.StateAt(p);
      pgm += static_cast<char>(state == mapping::CellState::kFree       ? 254
                               : state == mapping::CellState::kOccupied ? 0
                                                                        : 205);
    }
  }
  core::WriteFileAtomically(folder / kMapSliceImage, pgm);
  core::WriteFileAtomically(
      folder / kMapSliceLegend,
      fmt::format("image: {}\nresolution: {:.4f}\norigin: [{:.4f}, {:.4f}, 0.0]\nnegate: 0\nmode: trinary\n"
                  "occupied_thresh: 0.65\nfree_thresh: 0.196\n# height above the map's z = 0: {:.3f} m\n",
                  kMapSliceImage, pixel_m, box_map.min.x(), box_map.min.y(), height_m));
}

}  // namespace atlas::experiments
