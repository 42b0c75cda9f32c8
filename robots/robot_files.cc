#include "robots/robot_files.h"

#include <fmt/format.h>

#include <boost/property_tree/xml_parser.hpp>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/fingerprint.h"
#include "core/named_files.h"
#include "robots/read_xml.h"
#include "robots/robot_spec.h"

namespace atlas::robots {
namespace fs = std::filesystem;
namespace {

using boost::property_tree::ptree;

/// Puts what `include` names, relative to `folder`, in its place, and appends these files to `included`.
/// @throws InputError for a file that cannot be read, and where there is no end of them.
void ResolveIncludes(ptree* node, const fs::path& folder, std::vector<fs::path>* included, int depth = 0) {
  constexpr int kDeepest = 16;
  constexpr size_t kMost = 256;
  for (auto at = node->begin(); at != node->end();) {
    if (at->first != "include") {
      ResolveIncludes(&at->second, folder, included, depth);
      ++at;
      continue;
    }
    const fs::path file = folder / at->second.get("<xmlattr>.file", "");
    if (depth == kDeepest) throw core::InputError(file.string() + ": includes are nested too deeply");
    if (included->size() == kMost) {
      throw core::InputError(fmt::format("{}: one include more than {}", file.string(), included->size()));
    }
    included->push_back(file);
    ptree content = ReadXml(file);
    ResolveIncludes(&content, folder, included, depth + 1);
    at = node->erase(at);
    for (const auto& root : content) node->insert(at, root.second.begin(), root.second.end());
  }
}

struct Model {
  ptree tree;
  std::vector<fs::path> included;
};

Model ReadModel(const fs::path& mjcf) {
  Model model{ReadXml(mjcf), {}};
  ResolveIncludes(&model.tree, fs::absolute(mjcf).parent_path(), &model.included);
  return model;
}

AssetFolders FoldersOf(const ptree& tree, const fs::path& mjcf) {
  const fs::path folder = fs::absolute(mjcf).parent_path();
  AssetFolders folders{folder, folder};
  const auto model = tree.find("mujoco");
  if (model == tree.not_found()) throw core::InputError(mjcf.string() + ": no element 'mujoco'");
  for (const auto& [tag, child] : model->second) {
    if (tag != "compiler") continue;
    folders.meshes = folder / child.get("<xmlattr>.meshdir", "");
    folders.textures = folder / child.get("<xmlattr>.texturedir", "");
  }
  return folders;
}

/// Calls `visit(attribute, file)` for each attribute that names a file.
template <typename Visit>
void ForEachFile(ptree* node, const AssetFolders& folders, const Visit& visit) {
  for (auto& [tag, child] : *node) {
    if (tag == "mesh" || tag == "hfield" || tag == "skin" || tag == "texture") {
      const fs::path& folder = tag == "texture" ? folders.textures : folders.meshes;
      for (const char* name :
           {"file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback"}) {
        const auto attribute = child.get_child_optional(std::string("<xmlattr>.") + name);
        if (attribute) visit(&*attribute, (folder / attribute->data()).lexically_normal());
      }
    }
    ForEachFile(&child, folders, visit);
  }
}

bool NamesAssetFolder(const std::string& attribute) {
  return attribute == "meshdir" || attribute == "texturedir";
}

/// Elements and attributes; where assets lie does not count.
void Add(const ptree& node, core::Fingerprint* print) {
  for (const auto& [tag, child] : node) {
    if (tag == "<xmlattr>") {
      for (const auto& [name, value] : child) {
        if (!NamesAssetFolder(name)) print->Text(name + "=" + value.data());
      }
    } else {
      print->Text("<" + tag);
      Add(child, print);
    }
  }
  print->Text(">");
}

}  // namespace

AssetFolders AssetFoldersOf(const fs::path& mjcf) {
  return FoldersOf(ReadModel(mjcf).tree, mjcf);
}

std::string RobotDigest(const std::string& name_or_path) {
  const fs::path mjcf = LoadRobot(name_or_path).mjcf;
  ptree tree = ReadModel(mjcf).tree;
  core::Fingerprint print;
  ForEachFile(&tree, FoldersOf(tree, mjcf), [&](ptree* attribute, const fs::path& file) {
    print.Text(core::ReadFile(file));
    attribute->data() = file.filename().string();  // MuJoCo names meshes after their files
  });
  Add(tree, &print);
  return mjcf.stem().string() + "-" + print.Hex();
}

std::vector<fs::path> FilesOfRobot(const std::string& name_or_path) {
  const fs::path mjcf = LoadRobot(name_or_path).mjcf;
  Model model = ReadModel(mjcf);
  std::vector<fs::path> files = model.included;
  files.push_back(mjcf);
  ForEachFile(&model.tree, FoldersOf(model.tree, mjcf),
              [&](ptree*, const fs::path& file) { files.push_back(file); });
  for (const fs::path& file : files) core::CheckReadable(file);
  return files;
}

fs::path CopyRobot(const std::string& name_or_path, const fs::path& folder) {
  const fs::path mjcf = LoadRobot(name_or_path).mjcf, copy = folder / mjcf.filename();
  Model model = ReadModel(mjcf);
  std::vector<ptree*> attributes;
  std::vector<fs::path> files;
  ForEachFile(&model.tree, FoldersOf(model.tree, mjcf), [&](ptree* attribute, const fs::path& file) {
    attributes.push_back(attribute);
    files.push_back(file);
  });
  if (files.empty() && model.included.empty()) {
    core::CopyFile(mjcf, copy);
    return mjcf.filename();
  }
  const std::vector<fs::path> names = core::CopyNames(files);
  for (size_t i = 0; i < files.size(); ++i) {
    core::CopyFile(files[i], folder / "assets" / names[i]);
    attributes[i]->data() = (fs::path("assets") / names[i]).string();
  }
  for (auto& [tag, child] : model.tree.get_child("mujoco")) {
    const auto settings = child.get_child_optional("<xmlattr>");
    if (tag != "compiler" || !settings) continue;
    settings->erase("meshdir");
    settings->erase("texturedir");
  }
  std::ostringstream xml;
  boost::property_tree::write_xml(xml, model.tree);
  core::WriteFileAtomically(copy, xml.str());
  return mjcf.filename();
}

}  // namespace atlas::robots
