#include "scenes/catalog.h"

#include "core/catalog.h"
#include "core/named_files.h"
#include "scenes/scenes.h"

namespace atlas::scenes {
namespace {

template <SceneSpec (*kBuilder)()>
SceneSpec Named(const char* name, const char* doc) {
  SceneSpec scene = kBuilder();
  scene.name = name;
  scene.doc = doc;
  return scene;
}

}  // namespace

const std::vector<CatalogEntry>& Catalog() {
  static const std::vector<CatalogEntry> catalog = {
#define ATLAS_SCENE(name, builder, doc) CatalogEntry{name, doc, [] { return Named<builder>(name, doc); }},
#include "scenes/catalog.inc"
#undef ATLAS_SCENE
  };
  return catalog;
}

SceneSpec LoadScene(const std::string& name_or_path) {
  const bool is_file = core::FindEntry(Catalog(), name_or_path) == nullptr && core::IsFileName(name_or_path);
  return is_file ? LoadSceneFile(name_or_path) : core::EntryNamed(Catalog(), "scene", name_or_path).build();
}

}  // namespace atlas::scenes
