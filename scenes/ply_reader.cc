#include "scenes/ply_reader.h"

#include <fmt/format.h>

#include <string>

#include "core/errors.h"
#include "core/ply_format.h"

namespace atlas::scenes {
namespace {

using core::InputError;

uint32_t CheckedIndex(double index, size_t vertices) {
  if (index >= 0.0 && index < static_cast<double>(vertices)) return static_cast<uint32_t>(index);
  throw InputError(fmt::format("a face names vertex {} of {}", index, vertices));
}

void ReadRecord(const core::PlyElement& element, core::PlyValues& values, core::TriMesh& mesh) {
  core::Vec3f p = core::Vec3f::Zero();
  for (const core::PlyProperty& property : element.properties) {
    if (!property.is_list) {
      const double value = values.Next(property.type);
      for (int k = 0; k < 3; ++k) {
        if (property.name == std::string(1, "xyz"[k])) p[k] = static_cast<float>(value);
      }
      continue;
    }
    const double count = values.Next(property.count_type);
    const bool is_face = element.name == "face" && property.name.starts_with("vertex_ind");
    std::array<uint32_t, 3> t = {0, 0, 0};
    for (double k = 0; k < count; ++k) {
      const double value = values.Next(property.type);
      if (!is_face) continue;
      const uint32_t index = CheckedIndex(value, mesh.vertices.size());
      t = k == 0 ? std::array{index, index, index} : std::array{t[0], t[2], index};
      if (k >= 2) mesh.triangles.push_back(t);
    }
  }
  if (element.name == "vertex") mesh.vertices.push_back(p);
}

}  // namespace

core::TriMesh ParsePly(std::string_view bytes) {
  const core::PlyHeader header = core::ReadPlyHeader(bytes);
  core::PlyValues values(bytes, header);
  core::TriMesh mesh;
  for (const core::PlyElement& element : header.elements) {
    if (element.properties.empty()) continue;
    for (size_t k = 0; k < element.count; ++k) ReadRecord(element, values, mesh);
  }
  return mesh;
}

}  // namespace atlas::scenes
