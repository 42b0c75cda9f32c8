#include "scenes/scene_files.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>

#include "core/files.h"
#include "core/fingerprint.h"
#include "core/named_files.h"
#include "core/yaml_text.h"
#include "scenes/catalog.h"
#include "scenes/yaml_fields.h"

namespace atlas::scenes {
namespace fs = std::filesystem;
namespace {

/// The scene's YAML, and the nodes in it that name meshes.
struct SceneFile {
  YAML::Node root;
  std::vector<YAML::Node> mesh_nodes;
  std::vector<fs::path> meshes;  ///< a node each, as LoadSceneFile finds them
};

SceneFile Read(const fs::path& scene) {
  YamlFields::FromFile(scene);  // complains with the line
  SceneFile file{core::LoadYaml(scene), {}, {}};
  const YAML::Node parts = file.root["parts"];
  if (!parts || !parts.IsSequence()) return file;
  for (YAML::Node part : parts) {
    if (!part.IsMap() || !part["mesh"] || !part["mesh"].IsScalar()) continue;
    const fs::path mesh = part["mesh"].Scalar();
    file.mesh_nodes.push_back(part["mesh"]);
    file.meshes.push_back(mesh.is_absolute() ? mesh : scene.parent_path() / mesh);
  }
  return file;
}

/// Fields by their values alone: comments, order of keys and layout do not count.
void Add(const YAML::Node& node, core::Fingerprint* print) {
  print->Value(static_cast<int>(node.Type()));
  if (node.IsScalar()) print->Text(node.Scalar());
  if (node.IsSequence()) {
    print->Value(static_cast<uint64_t>(node.size()));
    for (const auto& item : node) Add(item, print);
  }
  if (!node.IsMap()) return;
  std::vector<std::string> keys;
  for (const auto& entry : node) keys.push_back(entry.first.as<std::string>(""));
  std::sort(keys.begin(), keys.end());
  for (const std::string& key : keys) {
    print->Text(key);
    Add(node[key], print);
  }
}

bool IsBuiltIn(const std::string& name) {
  return std::any_of(Catalog().begin(), Catalog().end(),
                     [&](const CatalogEntry& entry) { return entry.name == name; });
}

}  // namespace

std::string SceneDigest(const std::string& name_or_path) {
  if (IsBuiltIn(name_or_path)) return name_or_path;
  SceneFile file = Read(name_or_path);
  core::Fingerprint print;
  for (size_t i = 0; i < file.meshes.size(); ++i) {
    print.Text(core::ReadFile(file.meshes[i]));
    file.mesh_nodes[i] = file.meshes[i].filename().string();  // parts are named after their meshes
  }
  Add(file.root, &print);
  return fs::path(name_or_path).stem().string() + "-" + print.Hex();
}

std::vector<fs::path> FilesOfScene(const std::string& name_or_path) {
  if (IsBuiltIn(name_or_path)) return {};
  std::vector<fs::path> files = Read(name_or_path).meshes;
  files.emplace_back(name_or_path);
  return files;
}

fs::path CopyScene(const fs::path& scene, const fs::path& folder) {
  SceneFile file = Read(scene);
  const std::vector<fs::path> names = core::CopyNames(file.meshes);
  for (size_t i = 0; i < names.size(); ++i) {
    core::CopyFile(file.meshes[i], folder / names[i]);
    file.mesh_nodes[i] = names[i].string();
  }
  std::ostringstream yaml;
  yaml << file.root << "\n";
  core::WriteFileAtomically(folder / scene.filename(), yaml.str());
  return scene.filename();
}

std::string KeepScene(const std::string& name_or_path, const fs::path& folder) {
  if (IsBuiltIn(name_or_path)) return name_or_path;
  LoadScene(name_or_path);  // complaints name the user's file, not the copy
  return ("scene" / CopyScene(name_or_path, folder / "scene")).string();
}

}  // namespace atlas::scenes
