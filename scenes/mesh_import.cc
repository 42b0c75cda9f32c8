#include "scenes/mesh_import.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <map>
#include <tuple>

#include "core/errors.h"

namespace atlas::scenes {
namespace {

constexpr double kGreatestSpan_m = 1000.0;

std::string Lowercase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Joins corners at equal places; assimp's own joining keeps those apart whose normals or colours differ.
class Joiner {
 public:
  explicit Joiner(core::TriMesh* mesh) : mesh_(mesh) {}

  uint32_t Add(const core::Vec3f& p) {
    const auto [it, added] =
        places_.emplace(std::tuple{p.x(), p.y(), p.z()}, static_cast<uint32_t>(mesh_->vertices.size()));
    if (added) mesh_->vertices.push_back(p);
    return it->second;
  }

 private:
  core::TriMesh* mesh_;
  std::map<std::tuple<float, float, float>, uint32_t> places_;
};

core::TriMesh Collect(const aiScene& scene, const std::filesystem::path& path, double scale) {
  core::TriMesh mesh;
  Joiner joiner(&mesh);
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& v = part.mVertices[i];
      if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) continue;
      throw core::InputError(
          fmt::format("{}: vertex {} is not finite ({}, {}, {})", path.string(), i, v.x, v.y, v.z));
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      std::array<uint32_t, 3> t;
      for (int k = 0; k < 3; ++k) {
        const aiVector3D& v = part.mVertices[face.mIndices[k]];
        const core::Vec3 p = scale * core::Vec3(v.x, v.y, v.z);
        t[k] = joiner.Add(p.cast<float>());
      }
      const core::Vec3f a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
      if ((b - a).cross(c - a).norm() > 0.0f) mesh.triangles.push_back(t);
    }
  }
  return mesh;
}

}  // namespace

core::TriMesh ImportMesh(const std::filesystem::path& path, double scale) {
  if (!std::filesystem::exists(path)) throw core::InputError(path.string() + ": no such file");
  if (!std::filesystem::is_regular_file(path)) throw core::InputError(path.string() + ": not a file");
  const std::string kind = Lowercase(path.extension().string());
  if (kind != ".obj" && kind != ".ply" && kind != ".stl") {
    throw core::InputError(
        fmt::format("{}: '{}' is not a mesh format read here (.obj, .ply, .stl)", path.string(), kind));
  }
  if (std::filesystem::file_size(path) == 0) throw core::InputError(path.string() + ": the file is empty");
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason) c = c == '\n' ? ' ' : c;
    throw core::InputError(fmt::format("{}: unreadable ({})", path.string(), reason));
  }
  core::TriMesh mesh = Collect(*scene, path, scale);
  if (mesh.triangles.empty()) throw core::InputError(path.string() + ": holds no triangles with area");
  const double span = mesh.Bounds().Size().maxCoeff();
  if (span > kGreatestSpan_m) {
    throw core::InputError(
        fmt::format("{}: spans {:.0f} m at scale {} (limit {:.0f} m; millimetres need scale 0.001)",
                    path.string(), span, scale, kGreatestSpan_m));
  }
  return mesh;
}

}  // namespace atlas::scenes
