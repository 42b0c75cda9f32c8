#include "sim/world/world_model.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <cstring>

#include "core/errors.h"
#include "sim/world/mujoco_guard.h"
#include "sim/world/world_mjcf.h"

namespace atlas::sim {
namespace {

/// Heights go in after the load: MJCF of this version carries none.
void FillHeightFields(const scenes::SceneSpec& scene, mjModel* m) {
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    for (size_t j = 0; j < scene.parts[i].collision.size(); ++j) {
      const auto* grid = std::get_if<scenes::HeightGridShape>(&scene.parts[i].collision[j].shape);
      if (grid == nullptr) continue;
      const int id = mj_name2id(m, mjOBJ_HFIELD, StaticShapeName(i, j).c_str());
      const float low = *std::min_element(grid->height_m.begin(), grid->height_m.end());
      const auto scale = static_cast<float>(m->hfield_size[4 * id + 2]);
      float* out = m->hfield_data + m->hfield_adr[id];
      for (const float z : grid->height_m) *out++ = (z - low) / scale;
    }
  }
}

}  // namespace

void ModelDeleter::operator()(mjModel* m) const {
  mj_deleteModel(m);
}

ModelPtr CompileModel(const scenes::SceneSpec& scene, const robots::RobotSpec& robot) {
  InstallMujocoHandlers();
  const std::string xml = ComposeMjcf(scene, robot);
  auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  const char* file = "atlas_world.xml";
  mj_makeEmptyFileVFS(vfs.get(), file, static_cast<int>(xml.size()) + 1);
  std::memcpy(vfs->filedata[mj_findFileVFS(vfs.get(), file)], xml.c_str(), xml.size() + 1);
  char error[1000] = "";
  mjModel* raw = nullptr;
  std::string fatal;
  try {
    raw = mj_loadXML(file, vfs.get(), error, sizeof(error));
  } catch (const std::runtime_error& e) {
    fatal = e.what();
  }
  mj_deleteVFS(vfs.get());
  if (raw == nullptr) {
    std::string reason = fatal.empty() ? error : fatal;
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw core::InputError(
        fmt::format("scene {} with robot {}: {}", scene.name, robot.mjcf.string(), reason));
  }
  FillHeightFields(scene, raw);
  return ModelPtr(raw);
}

}  // namespace atlas::sim
