// Is a point inside a solid? By winding number, so solids may overlap.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/mesh.h"

namespace atlas::scenes {

/// Whether every directed edge of the mesh is met by its opposite: vertices at equal places count as one, so
/// shells read from files without shared indices qualify too.
bool IsWatertight(const core::TriMesh& mesh);

/// Volume of a watertight mesh in m^3: negative where its faces look inward.
double SignedVolume(const core::TriMesh& mesh);
void TurnInsideOut(core::TriMesh* mesh);

/// The mesh's connected pieces (corners at equal places are joined), in the order of their first triangles.
std::vector<core::TriMesh> SplitShells(const core::TriMesh& mesh);

/// Answers "is p inside any of these shells" for millions of points.
///
/// Casts a ray straight up and adds +1 for each surface it leaves by and -1 for each it enters by; the sum is
/// the winding number, non-zero inside. Triangles are binned in columns over x and y; vertical ones cannot be
/// crossed and are left out. An edge shared by two triangles is crossed by exactly one of them.
class SolidTest {
 public:
  /// @pre every mesh is watertight.
  explicit SolidTest(const std::vector<const core::TriMesh*>& shells);

  bool IsInside(const core::Vec3& p_map) const { return Winding(p_map) != 0; }
  /// How many shells hold the point, where every shell is simple and faces outward.
  int Winding(const core::Vec3& p_map) const;
  /// Index of the first shell that holds the point, or -1.
  int FirstShellAround(const core::Vec3& p_map) const;

 private:
  struct Triangle {
    core::Vec3 corner[3];
    double z_max;
    int sign;   ///< +1 facing up, -1 facing down
    int shell;  ///< index into the constructor's list
  };

  /// Calls `visit(triangle)` for each that the ray from p straight up crosses.
  template <typename Visit>
  void ForEachCrossing(const core::Vec3& p, const Visit& visit) const;

  int CellOf(double value, double min, int count) const;

  std::vector<Triangle> triangles_;
  core::Box3 bounds_;
  double cell_size_m_ = 0.25;
  int columns_ = 0, rows_ = 0;
  std::vector<uint32_t> cell_start_;  ///< prefix sums into cell_triangles_
  std::vector<uint32_t> cell_triangles_;
};

}  // namespace atlas::scenes
