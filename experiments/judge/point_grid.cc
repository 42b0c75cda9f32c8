#include "experiments/judge/point_grid.h"

#include <cassert>
#include <cmath>
#include <numeric>

namespace atlas::experiments {
namespace {

using core::Vec3f;

constexpr int kBlockCells = 8 * 8 * 8;
constexpr double kMaxBlocks = 1 << 27;

int LocalIndex(int x, int y, int z) {
  return (x & 7) | ((y & 7) << 3) | ((z & 7) << 6);
}

}  // namespace

PointGrid::PointGrid(std::span<const Vec3f> points, double cell_m) : cell_m_(cell_m) {
  assert(cell_m > 0.0);
  inverse_cell_ = static_cast<float>(1.0 / cell_m);
  if (points.empty()) {
    begin_ = {0};
    return;
  }
  Vec3f lo = points[0], hi = points[0];
  for (const Vec3f& p : points) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  origin_ = lo;
  double total = 1.0;
  for (int a = 0; a < 3; ++a) {
    blocks_[a] = static_cast<int>((hi[a] - lo[a]) * inverse_cell_) / 8 + 1;
    cells_[a] = 8 * blocks_[a];
    total *= blocks_[a];
  }
  assert(total < kMaxBlocks);
  (void)total;
  block_.assign(static_cast<size_t>(blocks_[0]) * blocks_[1] * blocks_[2], -1);

  std::vector<uint32_t> cell_of(points.size());
  int32_t used = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    int c[3];
    for (int a = 0; a < 3; ++a) c[a] = static_cast<int>((points[i][a] - origin_[a]) * inverse_cell_);
    const size_t slot =
        (static_cast<size_t>(c[2] >> 3) * blocks_[1] + (c[1] >> 3)) * blocks_[0] + (c[0] >> 3);
    if (block_[slot] < 0) block_[slot] = used++;
    cell_of[i] = static_cast<uint32_t>(block_[slot] * kBlockCells + LocalIndex(c[0], c[1], c[2]));
  }
  begin_.assign(static_cast<size_t>(used) * kBlockCells + 1, 0);
  for (const uint32_t cell : cell_of) ++begin_[cell + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  entries_.resize(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    entries_[next[cell_of[i]]++] = {points[i], static_cast<uint32_t>(i)};
}

bool PointGrid::CellsAround(const Vec3f& p, float radius_m, CellRange* range) const {
  // A hair wider than asked for, so that rounding cannot lose a cell.
  const float reach = radius_m * 1.0001f + 1e-5f;
  for (int a = 0; a < 3; ++a) {
    const float lo = (p[a] - reach - origin_[a]) * inverse_cell_,
                hi = (p[a] + reach - origin_[a]) * inverse_cell_;
    if (!(hi >= 0.0f) || !(lo < static_cast<float>(cells_[a]))) return false;
    range->lo[a] = std::max(0, static_cast<int>(lo));
    range->hi[a] = hi < static_cast<float>(cells_[a]) ? static_cast<int>(hi) : cells_[a] - 1;
  }
  return true;
}

int32_t PointGrid::CellAt(int x, int y, int z) const {
  const int32_t block = block_[(static_cast<size_t>(z >> 3) * blocks_[1] + (y >> 3)) * blocks_[0] + (x >> 3)];
  return block < 0 ? -1 : block * kBlockCells + LocalIndex(x, y, z);
}

void PointGrid::SearchCell(const Vec3f& p, int x, int y, int z, float* best_sq, int64_t* best) const {
  // Skip a cell whose nearest face lies beyond the best so far.
  const float cell = static_cast<float>(cell_m_);
  const int at[3] = {x, y, z};
  float gap_sq = 0.0f;
  for (int a = 0; a < 3; ++a) {
    const float lo = origin_[a] + static_cast<float>(at[a]) * cell;
    const float gap = std::max({lo - p[a], p[a] - (lo + cell), 0.0f});
    gap_sq += gap * gap;
  }
  if (gap_sq * 0.999f - 1e-8f > *best_sq) return;
  const int32_t id = CellAt(x, y, z);
  if (id < 0) return;
  for (uint32_t i = CellBegin(id); i < CellEnd(id); ++i) {
    const float d = (entries_[i].p - p).squaredNorm();
    const int64_t index = entries_[i].index;
    if (d < *best_sq || (d == *best_sq && (*best < 0 || index < *best))) {
      *best_sq = d;
      *best = index;
    }
  }
}

void PointGrid::SearchRing(const Vec3f& p, const std::array<int, 3>& home, int ring, float* best_sq,
                           int64_t* best) const {
  const int z_lo = std::max(home[2] - ring, 0), z_hi = std::min(home[2] + ring, cells_[2] - 1);
  const int y_lo = std::max(home[1] - ring, 0), y_hi = std::min(home[1] + ring, cells_[1] - 1);
  const int x_lo = std::max(home[0] - ring, 0), x_hi = std::min(home[0] + ring, cells_[0] - 1);
  for (int z = z_lo; z <= z_hi; ++z) {
    for (int y = y_lo; y <= y_hi; ++y) {
      const bool face = std::abs(z - home[2]) == ring || std::abs(y - home[1]) == ring;
      if (face) {
        for (int x = x_lo; x <= x_hi; ++x) SearchCell(p, x, y, z, best_sq, best);
      } else {
        if (home[0] - ring >= 0 && home[0] - ring < cells_[0])
          SearchCell(p, home[0] - ring, y, z, best_sq, best);
        if (home[0] + ring >= 0 && home[0] + ring < cells_[0])
          SearchCell(p, home[0] + ring, y, z, best_sq, best);
      }
    }
  }
}

int64_t PointGrid::Nearest(const Vec3f& p, float limit_m, float* distance_m) const {
  CellRange range;
  if (entries_.empty() || !CellsAround(p, limit_m, &range)) return -1;
  std::array<int, 3> home;
  for (int a = 0; a < 3; ++a) home[a] = static_cast<int>(std::floor((p[a] - origin_[a]) * inverse_cell_));
  float best_sq = limit_m * limit_m;
  int64_t best = -1;
  const int rings = static_cast<int>(limit_m * inverse_cell_) + 1;
  for (int ring = 0; ring <= rings; ++ring) {
    // Cells of this ring are at least (ring - 1) cells away.
    const float nearest = static_cast<float>(std::max(ring - 1, 0) * cell_m_);
    if (nearest * nearest > best_sq * 1.001f) break;
    SearchRing(p, home, ring, &best_sq, &best);
  }
  if (best >= 0) *distance_m = std::sqrt(best_sq);
  return best;
}

std::vector<uint32_t> ThinIndices(std::span<const Vec3f> points, double spacing_m) {
  const PointGrid grid(points, spacing_m);
  std::vector<uint32_t> kept;
  for (size_t cell = 0; cell < grid.cell_count(); ++cell) {
    const int32_t id = static_cast<int32_t>(cell);
    if (grid.CellBegin(id) < grid.CellEnd(id)) kept.push_back(grid.entries()[grid.CellBegin(id)].index);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

}  // namespace atlas::experiments
