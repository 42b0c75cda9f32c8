// A mesh in the renderer's memory, in chunks that are culled one by one.
#pragma once

#include "sim/render/colored_mesh.h"
#include "sim/render/gl_api.h"

namespace atlas::sim {

/// All members need the context that made it to be current.
class GpuMesh {
 public:
  GpuMesh(const gl::Api& api, const ColoredMesh& mesh);
  ~GpuMesh();
  GpuMesh(const GpuMesh&) = delete;
  GpuMesh& operator=(const GpuMesh&) = delete;

  /// Draws the chunks that may lie inside the clip volume of `T_clip_mesh`.
  void Draw(const Eigen::Matrix4d& T_clip_mesh) const;

 private:
  struct Chunk {
    int first_vertex, vertices;
    core::Box3 bounds;
  };

  const gl::Api& api_;
  gl::Uint array_ = 0, buffer_ = 0;
  std::vector<Chunk> chunks_;
};

}  // namespace atlas::sim
