#include "core/files.h"
#include "robots/builders.h"
#include "robots/mjcf_mounts.h"

namespace atlas::robots {

RobotSpec Quadruped() {
  RobotSpec spec;
  spec.name = "quadruped";
  spec.mjcf = core::InstalledFile("robots/quadruped.xml");
  ReadMounts(&spec);
  return spec;
}

}  // namespace atlas::robots
