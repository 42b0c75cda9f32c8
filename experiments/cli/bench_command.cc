#include <fmt/format.h>

#include <iostream>

#include "core/errors.h"
#include "experiments/cli/commands.h"
#include "scenes/catalog.h"
#include "sim/sensors/raycaster_bench.h"

namespace atlas::experiments {

int BenchCommand(const std::string& what, const std::string& scene) {
  if (what != "lidar") throw core::InputError(core::UnknownName("bench", what, {"lidar"}));
  const core::LidarModel lidar = core::FindLidarModel("vlp16");
  std::cout << fmt::format("{:<20} {:>10} {:>12} {:>14} {:>8} {:>12}\n", "scene", "triangles", "rays/s",
                           "bare Embree/s", "share", "ms a spin");
  for (const auto& entry : scenes::Catalog()) {
    if (!scene.empty() && entry.name != scene) continue;
    const sim::RaycasterSpeed speed = sim::MeasureRaycaster(entry.build(), lidar, 1.0);
    std::cout << fmt::format("{:<20} {:10} {:12.3e} {:14.3e} {:6.1f} % {:12.2f}\n", entry.name,
                             speed.triangles, speed.rays_per_second, speed.bare_rays_per_second,
                             100.0 * speed.rays_per_second / speed.bare_rays_per_second, speed.spin_ms);
  }
  return 0;
}

}  // namespace atlas::experiments
