#include "mapping/slam/localiser.h"

#include "core/catalog.h"
#include "mapping/slam/builders.h"

namespace atlas::mapping {

void LocalisationParams::Visit(core::ParamVisitor& v) {
  std::vector<std::string> names;
  for (const LocaliserEntry& entry : LocaliserCatalog()) names.push_back(entry.name);
  v.Field("name", &name,
          {.choices = names,
           .doc = "truth: the true pose but for noise; none: odometry alone, so drift reaches map and score; "
                  "slam: a pose graph"});
  v.Field("sigma_m", &sigma_m,
          {.unit = "m",
           .min = 0.0,
           .max = 0.5,
           .doc = "truth: noise on the base position in the map (standard deviation of each axis)"});
  v.Field("sigma_deg", &sigma_deg,
          {.unit = "deg",
           .min = 0.0,
           .max = 5.0,
           .doc = "truth: noise on the base attitude in the map (standard deviation of each axis)"});
  v.Field(
      "period_s", &period_s,
      {.unit = "s", .min = 0.0, .max = 60.0, .doc = "truth: from one fix to the next; 0: at every state"});
  core::AbsentFields absent(&v, "localisation.name = " + name);
  core::ParamVisitor& none = absent;
  slam.Visit(name == "slam" ? v : none);
  if (lidar && name != "truth") v.Section("lidar_odometry", &lidar_odometry);
}

const std::vector<LocaliserEntry>& LocaliserCatalog() {
  static const std::vector<LocaliserEntry> kCatalog = {
#define X(name, builder, doc) {name, doc, builder},
#include "mapping/slam/catalog.inc"
#undef X
  };
  return kCatalog;
}

std::unique_ptr<Localiser> MakeLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                         const core::Rng& rng) {
  return core::EntryNamed(LocaliserCatalog(), "localisation", params.name).build(params, start, rng);
}

}  // namespace atlas::mapping
