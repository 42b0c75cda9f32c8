#include "core/errors.h"
#include "scenes/catalog.h"

namespace atlas::scenes {

SceneSpec LoadSceneFile(const std::filesystem::path& path) {
  throw core::InputError(path.string() + ": no such scene file");
}

}  // namespace atlas::scenes
