#include "robots/robot_spec.h"

#include "core/errors.h"
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

RobotSpec LoadRobot(const std::string& name_or_path) {
  std::vector<std::string> names;
  for (const CatalogEntry& entry : Catalog()) {
    if (entry.name == name_or_path) {
      RobotSpec spec = entry.build();
      spec.doc = entry.doc;
      return spec;
    }
    names.push_back(entry.name);
  }
  const std::filesystem::path path(name_or_path);
  if (path.extension() != ".xml") throw core::InputError(core::UnknownName("robot", name_or_path, names));
  RobotSpec spec;
  spec.name = path.stem().string();
  spec.mjcf = path;
  ReadMounts(&spec);
  return spec;
}

}  // namespace atlas::robots
