#include "sim/render/gpu_mesh.h"

#include <cassert>
#include <numeric>

namespace atlas::sim {
namespace {

constexpr size_t kChunkTriangles = 256;

struct Vertex {
  float position[3];
  int8_t normal[4];
  uint8_t rgba[4];
};

/// Triangles in an order that keeps neighbours together: halved at the median of the widest axis until a half
/// is a chunk. Appends the size of each chunk.
void SortIntoChunks(std::vector<uint32_t>::iterator begin, std::vector<uint32_t>::iterator end,
                    const std::vector<core::Vec3f>& center, std::vector<size_t>* sizes) {
  const auto count = static_cast<size_t>(end - begin);
  if (count <= kChunkTriangles) {
    if (count > 0) sizes->push_back(count);
    return;
  }
  core::Box3 box;
  for (auto t = begin; t != end; ++t) box.Extend(center[*t].cast<double>());
  int axis = 0;
  box.Size().maxCoeff(&axis);
  const auto middle = begin + static_cast<ptrdiff_t>(count / 2);
  std::nth_element(begin, middle, end,
                   [&](uint32_t a, uint32_t b) { return center[a][axis] < center[b][axis]; });
  SortIntoChunks(begin, middle, center, sizes);
  SortIntoChunks(middle, end, center, sizes);
}

/// False where all corners lie beyond one of the clip planes.
bool MayBeVisible(const core::Box3& box, const Eigen::Matrix4d& T_clip_mesh) {
  unsigned outside_all = 0x3f;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector4d clip = T_clip_mesh * Eigen::Vector4d(corner & 1 ? box.max.x() : box.min.x(),
                                                               corner & 2 ? box.max.y() : box.min.y(),
                                                               corner & 4 ? box.max.z() : box.min.z(), 1.0);
    unsigned outside = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (clip[axis] < -clip.w()) outside |= 1u << (2 * axis);
      if (clip[axis] > clip.w()) outside |= 2u << (2 * axis);
    }
    outside_all &= outside;
  }
  return outside_all == 0;
}

void SetAttribute(const gl::Api& api, gl::Uint index, int size, gl::Enum type, bool normalized,
                  size_t offset) {
  api.EnableVertexAttribArray(index);
  api.VertexAttribPointer(index, size, type, normalized ? 1 : 0, sizeof(Vertex),
                          reinterpret_cast<const void*>(offset));
}

}  // namespace

GpuMesh::GpuMesh(const gl::Api& api, const ColoredMesh& colored) : api_(api) {
  const core::TriMesh& mesh = colored.mesh;
  assert(colored.rgb.size() == 1 || colored.rgb.size() == mesh.triangles.size());
  std::vector<core::Vec3f> center;
  center.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    center.push_back((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0f);
  }
  std::vector<uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<size_t> sizes;
  SortIntoChunks(order.begin(), order.end(), center, &sizes);

  std::vector<Vertex> vertices;
  vertices.reserve(3 * order.size());
  size_t next = 0;
  for (const size_t size : sizes) {
    Chunk chunk{static_cast<int>(vertices.size()), static_cast<int>(3 * size), {}};
    for (size_t k = 0; k < size; ++k, ++next) {
      const auto& t = mesh.triangles[order[next]];
      const Rgb& rgb = colored.rgb[colored.rgb.size() == 1 ? 0 : order[next]];
      const core::Vec3f& a = mesh.vertices[t[0]];
      const core::Vec3f n =
          127.0f * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).stableNormalized();
      for (const uint32_t corner : t) {
        const core::Vec3f& p = mesh.vertices[corner];
        chunk.bounds.Extend(p.cast<double>());
        vertices.push_back(
            {{p.x(), p.y(), p.z()},
             {static_cast<int8_t>(n.x()), static_cast<int8_t>(n.y()), static_cast<int8_t>(n.z()), 0},
             {rgb[0], rgb[1], rgb[2], 255}});
      }
    }
    chunks_.push_back(chunk);
  }
  api_.GenVertexArrays(1, &array_);
  api_.BindVertexArray(array_);
  api_.GenBuffers(1, &buffer_);
  api_.BindBuffer(gl::kArrayBuffer, buffer_);
  api_.BufferData(gl::kArrayBuffer, static_cast<ptrdiff_t>(vertices.size() * sizeof(Vertex)), vertices.data(),
                  gl::kStaticDraw);
  SetAttribute(api_, 0, 3, gl::kFloat, false, offsetof(Vertex, position));
  SetAttribute(api_, 1, 3, gl::kByte, true, offsetof(Vertex, normal));
  SetAttribute(api_, 2, 3, gl::kUnsignedByte, true, offsetof(Vertex, rgba));
  api_.BindVertexArray(0);
}

GpuMesh::~GpuMesh() {
  api_.DeleteVertexArrays(1, &array_);
  api_.DeleteBuffers(1, &buffer_);
}

void GpuMesh::Draw(const Eigen::Matrix4d& T_clip_mesh) const {
  std::vector<int> first, count;
  for (const Chunk& chunk : chunks_) {
    if (!MayBeVisible(chunk.bounds, T_clip_mesh)) continue;
    if (!first.empty() && first.back() + count.back() == chunk.first_vertex) {
      count.back() += chunk.vertices;
    } else {
      first.push_back(chunk.first_vertex);
      count.push_back(chunk.vertices);
    }
  }
  if (first.empty()) return;
  api_.BindVertexArray(array_);
  api_.MultiDrawArrays(gl::kTriangles, first.data(), count.data(), static_cast<int>(first.size()));
}

}  // namespace atlas::sim
