#include "robots/robot_spec.h"

#include "core/catalog.h"
#include "robots/builders.h"
#include "robots/mjcf_mounts.h"

namespace atlas::robots {

const std::vector<CatalogEntry>& Catalog() {
  static const std::vector<CatalogEntry> catalog = {
#define ATLAS_ROBOT(name, builder, doc) {name, doc, &builder},
#include "robots/catalog.inc"
#undef ATLAS_ROBOT
  };
  return catalog;
}

core::LidarModel LidarOf(const RobotSpec& robot, const std::string& name) {
  return core::FindLidarModel(name == "robot" ? robot.lidar_model : name);
}

RobotSpec LoadRobot(const std::string& name_or_path) {
  const std::filesystem::path path(name_or_path);
  const CatalogEntry* entry = core::FindEntry(Catalog(), name_or_path);
  if (entry == nullptr && path.extension() != ".xml") core::EntryNamed(Catalog(), "robot", name_or_path);
  if (entry != nullptr) {
    RobotSpec spec = entry->build();
    spec.doc = entry->doc;
    return spec;
  }
  RobotSpec spec;
  spec.name = path.stem().string();
  spec.mjcf = path;
  ReadMounts(&spec);
  return spec;
}

}  // namespace atlas::robots
