#include "scenes/catalog.h"

#include "core/errors.h"
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
  std::vector<std::string> names;
  for (const CatalogEntry& entry : Catalog()) {
    if (entry.name == name_or_path) return entry.build();
    names.push_back(entry.name);
  }
  if (core::IsFileName(name_or_path)) return LoadSceneFile(name_or_path);
  throw core::InputError(core::UnknownName("scene", name_or_path, names));
}

}  // namespace atlas::scenes
