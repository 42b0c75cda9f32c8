// The picture of a map at one height, read back byte by byte.
#include "experiments/results/map_slice.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/files.h"

namespace atlas::tests {
namespace {

namespace fs = std::filesystem;
using core::Vec3;

/// Half a metre a voxel: free for x < 0, a wall at 0 <= x < 0.5 where y >= 0, the rest unknown; all of it at
/// heights of 1 to 1.5 m alone.
class Wall final : public mapping::MapView {
 public:
  double resolution_m() const override { return 0.5; }
  mapping::CellState StateAt(const Vec3& p) const override {
    if (p.z() < 1.0 || p.z() >= 1.5) return mapping::CellState::kUnknown;
    if (p.x() < 0.0) return mapping::CellState::kFree;
    return p.x() < 0.5 && p.y() >= 0.0 ? mapping::CellState::kOccupied : mapping::CellState::kUnknown;
  }
  mapping::RayEnd Trace(const Vec3&, const Vec3&, const mapping::TraceLimits&,
                        std::vector<mapping::RaySample>*) const override {
    return mapping::RayEnd::kVoid;
  }
  void ForEachOccupied(const core::Box3&, const VisitCenter&) const override {}
};

TEST(MapSlice, IsTheMapAtThatHeightNorthUp) {
  const fs::path folder = fs::temp_directory_path() / ("atlas_slice_" + std::to_string(::getpid()));
  experiments::WriteMapSlice(folder, Wall(), {Vec3(-1.0, -0.5, 0.0), Vec3(1.0, 1.0, 3.0)}, 1.2);
  const std::string image = core::ReadFile(folder / "map_slice.pgm");
  const std::string head = "P5\n4 3\n255\n";
  ASSERT_EQ(image.substr(0, head.size()), head);
  const std::string f(1, static_cast<char>(254)), o(1, '\0'), u(1, static_cast<char>(205));
  EXPECT_EQ(image.substr(head.size()), f + f + o + u + f + f + o + u + f + f + u + u);
  const std::string legend = core::ReadFile(folder / "map_slice.yaml");
  for (const char* line : {"image: map_slice.pgm\n", "resolution: 0.5000\n",
                           "origin: [-1.0000, -0.5000, 0.0]\n", "negate: 0\n", "mode: trinary\n"})
    EXPECT_NE(legend.find(line), std::string::npos) << line;
  fs::remove_all(folder);
}

}  // namespace
}  // namespace atlas::tests
