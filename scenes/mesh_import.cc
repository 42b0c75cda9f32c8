#include "scenes/mesh_import.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <map>
#include <tuple>

#include "core/errors.h"
#include "core/files.h"
#include "scenes/ply_reader.h"

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

/// Every triangle of an OBJ or STL file, in the file's units. @throws InputError with the reason.
core::TriMesh ReadByAssimp(const std::filesystem::path& path) {
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason) c = c == '\n' ? ' ' : c;
    throw core::InputError(fmt::format("unreadable ({})", reason));
  }
  core::TriMesh mesh;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto base = static_cast<uint32_t>(mesh.vertices.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      mesh.vertices.emplace_back(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      for (int k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= part.mNumVertices) {
          throw core::InputError(
              fmt::format("a face names vertex {} of {}", face.mIndices[k], part.mNumVertices));
        }
      }
      mesh.triangles.push_back({base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
    }
  }
  return mesh;
}

/// Scales, joins equal corners and drops triangles without area.
core::TriMesh Cleaned(const core::TriMesh& raw, double scale) {
  core::TriMesh mesh;
  Joiner joiner(&mesh);
  for (std::array<uint32_t, 3> t : raw.triangles) {
    for (uint32_t& i : t) {
      const core::Vec3f& v = raw.vertices[i];
      if (!v.allFinite()) {
        throw core::InputError(fmt::format("vertex {} is not finite ({}, {}, {})", i, v.x(), v.y(), v.z()));
      }
      i = joiner.Add((scale * v.cast<double>()).cast<float>());
    }
    const core::Vec3f a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    if ((b - a).cross(c - a).norm() > 0.0f) mesh.triangles.push_back(t);
  }
  if (mesh.triangles.empty()) throw core::InputError("holds no triangles with area");
  const double span = mesh.Bounds().Size().maxCoeff();
  if (span > kGreatestSpan_m) {
    throw core::InputError(
        fmt::format("spans {:.0f} m at scale {} (limit {:.0f} m; millimetres need scale 0.001)", span, scale,
                    kGreatestSpan_m));
  }
  return mesh;
}

core::TriMesh ReadMeshFile(const std::filesystem::path& path, double scale) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw core::InputError("no such file");
  if (!std::filesystem::is_regular_file(path, error)) throw core::InputError("not a file");
  const std::string kind = Lowercase(path.extension().string());
  if (kind != ".obj" && kind != ".ply" && kind != ".stl") {
    throw core::InputError(fmt::format("'{}' is not a mesh format read here (.obj, .ply, .stl)", kind));
  }
  if (std::filesystem::file_size(path, error) == 0) throw core::InputError("the file is empty");
  return Cleaned(kind == ".ply" ? ParsePly(core::ReadFile(path)) : ReadByAssimp(path), scale);
}

}  // namespace

core::TriMesh ImportMesh(const std::filesystem::path& path, double scale) {
  try {
    return ReadMeshFile(path, scale);
  } catch (const core::InputError& error) {
    throw core::InputError(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace atlas::scenes
