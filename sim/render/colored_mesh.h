// A mesh with colours, and images: what the renderer takes and gives.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.h"

namespace atlas::sim {

using Rgb = std::array<uint8_t, 3>;

struct ColoredMesh {
  core::TriMesh mesh;
  std::vector<Rgb> rgb;  ///< one a triangle, or one for all
};

/// Row-major, top row first, three bytes a pixel.
struct RgbImage {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgb;
};

}  // namespace atlas::sim
