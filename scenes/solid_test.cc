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

/// For each vertex, the first one at its place.
std::vector<uint32_t> JoinedVertices(const core::TriMesh& mesh) {
  std::map<std::tuple<float, float, float>, uint32_t> places;
  std::vector<uint32_t> joined;
  for (uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    const core::Vec3f& v = mesh.vertices[i];
    joined.push_back(places.emplace(std::tuple{v.x(), v.y(), v.z()}, i).first->second);
  }
  return joined;
}

}  // namespace

bool IsWatertight(const core::TriMesh& mesh) {
  if (mesh.triangles.empty()) return false;
  const std::vector<uint32_t> joined = JoinedVertices(mesh);
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = joined[t[k]], b = joined[t[(k + 1) % 3]];
      if (a == b) continue;
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  for (const auto& [edge, count] : balance) {
    if (count != 0) return false;
  }
  return true;
}

double SignedVolume(const core::TriMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  const Vec3 origin = mesh.vertices[0].cast<double>();  // near by, so that little cancels
  double sixfold = 0.0;
  for (const auto& t : mesh.triangles) {
    Vec3 v[3];
    for (int k = 0; k < 3; ++k) v[k] = mesh.vertices[t[k]].cast<double>() - origin;
    sixfold += v[0].dot(v[1].cross(v[2]));
  }
  return sixfold / 6.0;
}

void TurnInsideOut(core::TriMesh* mesh) {
  for (auto& t : mesh->triangles) std::swap(t[1], t[2]);
}

std::vector<core::TriMesh> SplitShells(const core::TriMesh& mesh) {
  std::vector<uint32_t> root = JoinedVertices(mesh);
  const auto find = [&](uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& t : mesh.triangles) {
    for (int k = 1; k < 3; ++k) root[find(t[0])] = find(t[k]);
  }
  std::vector<core::TriMesh> shells;
  std::map<uint32_t, size_t> shell_of_root;
  constexpr uint32_t kUnused = ~0u;
  std::vector<uint32_t> place(mesh.vertices.size(), kUnused);
  for (std::array<uint32_t, 3> t : mesh.triangles) {
    const auto [it, added] = shell_of_root.emplace(find(t[0]), shells.size());
    if (added) shells.emplace_back();
    core::TriMesh& shell = shells[it->second];
    for (uint32_t& i : t) {
      if (place[i] == kUnused) {
        place[i] = static_cast<uint32_t>(shell.vertices.size());
        shell.vertices.push_back(mesh.vertices[i]);
      }
      i = place[i];
    }
    shell.triangles.push_back(t);
  }
  return shells;
}

SolidTest::SolidTest(const std::vector<const core::TriMesh*>& shells) {
  for (size_t index = 0; index < shells.size(); ++index) {
    for (const auto& t : shells[index]->triangles) {
      Triangle triangle;
      triangle.shell = static_cast<int>(index);
      for (int k = 0; k < 3; ++k) triangle.corner[k] = shells[index]->vertices[t[k]].cast<double>();
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

template <typename Visit>
void SolidTest::ForEachCrossing(const Vec3& p, const Visit& visit) const {
  if (triangles_.empty() || !bounds_.Contains(p)) return;
  const size_t cell = static_cast<size_t>(CellOf(p.y(), bounds_.min.y(), rows_)) * columns_ +
                      CellOf(p.x(), bounds_.min.x(), columns_);
  for (uint32_t i = cell_start_[cell]; i < cell_start_[cell + 1]; ++i) {
    const Triangle& t = triangles_[cell_triangles_[i]];
    if (t.z_max <= p.z()) continue;
    bool crossed = false;
    for (int k = 0; k < 3; ++k) crossed ^= CrossesEdge(&t.corner[k], &t.corner[(k + 1) % 3], p.x(), p.y());
    if (!crossed) continue;
    const Vec3 n = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]);
    const Vec3 from = p - t.corner[0];
    if (t.corner[0].z() - (n.x() * from.x() + n.y() * from.y()) / n.z() > p.z()) visit(t);
  }
}

int SolidTest::Winding(const Vec3& p) const {
  int winding = 0;
  ForEachCrossing(p, [&](const Triangle& t) { winding += t.sign; });
  return winding;
}

int SolidTest::FirstShellAround(const Vec3& p) const {
  std::map<int, int> winding;
  ForEachCrossing(p, [&](const Triangle& t) { winding[t.shell] += t.sign; });
  for (const auto& [shell, count] : winding) {
    if (count != 0) return shell;
  }
  return -1;
}

}  // namespace atlas::scenes
