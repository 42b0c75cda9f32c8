#include "experiments/results/scored_files.h"

#include <fmt/format.h>

#include <cassert>
#include <string>

#include "core/files.h"

namespace atlas::experiments {
namespace {

std::string PlyHeader(size_t vertices, const std::vector<const char*>& properties) {
  std::string header = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", vertices);
  for (const char* property : properties) header += fmt::format("property {}\n", property);
  return header + "end_header\n";
}

void Append(std::string* out, const core::Vec3f& v) {
  out->append(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
}

}  // namespace

void WriteScoredTruth(const std::filesystem::path& path, const scenes::GroundTruth& truth,
                      const std::vector<uint8_t>& attainable) {
  assert(truth.normals.size() == truth.points.size());
  assert(attainable.empty() || attainable.size() == truth.points.size());
  std::vector<const char*> properties = {"float x", "float y", "float z", "float nx", "float ny", "float nz"};
  if (!attainable.empty()) properties.push_back("uchar attainable");
  properties.push_back("uchar two_sided");
  std::string out = PlyHeader(truth.points.size(), properties);
  out.reserve(out.size() + 26 * truth.points.size());
  for (size_t i = 0; i < truth.points.size(); ++i) {
    Append(&out, truth.points[i]);
    Append(&out, truth.normals[i]);
    if (!attainable.empty()) out.push_back(attainable[i] != 0 ? 1 : 0);
    out.push_back(!truth.two_sided.empty() && truth.two_sided[i] != 0 ? 1 : 0);
  }
  core::WriteFileAtomically(path, out);
}

void WriteScoredCloud(const std::filesystem::path& path, const mapping::ReturnCloud& cloud, size_t count) {
  assert(count <= cloud.points.size() && cloud.points.size() == cloud.origins.size());
  std::string out =
      PlyHeader(count, {"float x", "float y", "float z", "float vp_x", "float vp_y", "float vp_z"});
  out.reserve(out.size() + 24 * count);
  for (size_t i = 0; i < count; ++i) {
    Append(&out, cloud.points[i]);
    Append(&out, cloud.origins[i]);
  }
  core::WriteFileAtomically(path, out);
}

void WriteAlignment(const std::filesystem::path& path, const core::Pose& T_truth_cloud) {
  std::string text;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      text += fmt::format("{:.12g}{}", T_truth_cloud(row, column), column < 3 ? ' ' : '\n');
    }
  }
  core::WriteFileAtomically(path, text);
}

}  // namespace atlas::experiments
