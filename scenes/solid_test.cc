#include "scenes/solid_test.h"

#include <map>
#include <tuple>

namespace atlas::scenes {
namespace {

using core::Vec3;

/// Whether the vertical line through (x, y) passes right of the edge a-b while y lies within the edge's span,
/// half open. Ends are ordered first, so that both triangles of an edge get bit-equal answers.
bool CrossesEdge(const Vec3* a, const Vec3* b, double x, double y) {
  if (a->y() > b->y() || (a->y() == b->y() && a->x() > b->x())) std::swap(a, b);
  if (!(a->y() <= y && y < b->y())) return false;
  return x < a->x() + (y - a->y()) * (b->x() - a->x()) / (b->y() - a->y());
}

}  // namespace

bool IsWatertight(const core::TriMesh& mesh) {
  if (mesh.triangles.empty()) return false;
  using Key = std::tuple<float, float, float>;
  std::map<Key, uint32_t> places;
  std::vector<uint32_t> place_of;
  for (const core::Vec3f& v : mesh.vertices) {
    place_of.push_back(
        places.emplace(Key{v.x(), v.y(), v.z()}, static_cast<uint32_t>(places.size())).first->second);
  }
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = place_of[t[k]], b = place_of[t[(k + 1) % 3]];
      if (a == b) continue;
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  for (const auto& [edge, count] : balance) {
    if (count != 0) return false;
  }
  return true;
}

SolidTest::SolidTest(const std::vector<const core::TriMesh*>& shells) {
  for (const core::TriMesh* shell : shells) {
    for (const auto& t : shell->triangles) {
      Triangle triangle;
      for (int k = 0; k < 3; ++k) triangle.corner[k] = shell->vertices[t[k]].cast<double>();
      const Vec3 *c = triangle.corner, u = c[1] - c[0], v = c[2] - c[0];
      const double doubled_area_xy = u.x() * v.y() - u.y() * v.x();
      if (doubled_area_xy == 0.0) continue;
      triangle.sign = doubled_area_xy > 0.0 ? 1 : -1;
      triangle.z_max = std::max({c[0].z(), c[1].z(), c[2].z()});
      for (int k = 0; k < 3; ++k) bounds_.Extend(c[k]);
      triangles_.push_back(triangle);
    }
  }
  if (triangles_.empty()) return;
  constexpr int kMostCells = 512;  // along an axis
  cell_size_m_ = std::max(cell_size_m_, bounds_.Size().head<2>().maxCoeff() / kMostCells);
  columns_ = static_cast<int>(bounds_.Size().x() / cell_size_m_) + 1;
  rows_ = static_cast<int>(bounds_.Size().y() / cell_size_m_) + 1;
  std::vector<std::vector<uint32_t>> cells(static_cast<size_t>(columns_) * rows_);
  for (uint32_t i = 0; i < triangles_.size(); ++i) {
    core::Box3 box;
    for (const Vec3& corner : triangles_[i].corner) box.Extend(corner);
    const int x1 = CellOf(box.max.x(), bounds_.min.x(), columns_),
              y1 = CellOf(box.max.y(), bounds_.min.y(), rows_);
    for (int y = CellOf(box.min.y(), bounds_.min.y(), rows_); y <= y1; ++y) {
      for (int x = CellOf(box.min.x(), bounds_.min.x(), columns_); x <= x1; ++x) {
        cells[static_cast<size_t>(y) * columns_ + x].push_back(i);
      }
    }
  }
  for (const auto& cell : cells) {
    cell_start_.push_back(static_cast<uint32_t>(cell_triangles_.size()));
    cell_triangles_.insert(cell_triangles_.end(), cell.begin(), cell.end());
  }
  cell_start_.push_back(static_cast<uint32_t>(cell_triangles_.size()));
}

int SolidTest::CellOf(double value, double min, int count) const {
  return std::clamp(static_cast<int>((value - min) / cell_size_m_), 0, count - 1);
}

bool SolidTest::IsInside(const Vec3& p) const {
  if (triangles_.empty() || !bounds_.Contains(p)) return false;
  const size_t cell = static_cast<size_t>(CellOf(p.y(), bounds_.min.y(), rows_)) * columns_ +
                      CellOf(p.x(), bounds_.min.x(), columns_);
  int winding = 0;
  for (uint32_t i = cell_start_[cell]; i < cell_start_[cell + 1]; ++i) {
    const Triangle& t = triangles_[cell_triangles_[i]];
    if (t.z_max <= p.z()) continue;
    bool crossed = false;
    for (int k = 0; k < 3; ++k) crossed ^= CrossesEdge(&t.corner[k], &t.corner[(k + 1) % 3], p.x(), p.y());
    if (!crossed) continue;
    const Vec3 n = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]);
    const double z =
        t.corner[0].z() - (n.x() * (p.x() - t.corner[0].x()) + n.y() * (p.y() - t.corner[0].y())) / n.z();
    if (z > p.z()) winding += t.sign;
  }
  return winding != 0;
}

}  // namespace atlas::scenes
