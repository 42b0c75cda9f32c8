#include "mapping/atlas/overlap_cloud.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mapping/cloud/voxel_filter.h"

namespace atlas::mapping {
namespace {

using core::Vec3f;
using CellAt = std::array<int, 3>;

constexpr int kBrickBits = 2, kBrickSide = 1 << kBrickBits;  ///< cells
constexpr int kReach = 2;                                    ///< cells that sqrt(3) sides reach

CellAt CellOf(const Vec3f& p, float side_m) {
  const Vec3f cell = (p / side_m).array().floor();
  return {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())};
}

uint64_t BitOf(const CellAt& cell) {
  constexpr int kMask = kBrickSide - 1;
  return uint64_t{1} << ((cell[0] & kMask) | (cell[1] & kMask) << kBrickBits |
                         (cell[2] & kMask) << 2 * kBrickBits);
}

size_t Hash(const CellAt& at) {
  constexpr int kBits = 21, kOffset = 1 << 20;
  const auto part = [](int v) { return static_cast<uint64_t>(v + kOffset); };
  const uint64_t code = part(at[0]) | part(at[1]) << kBits | part(at[2]) << 2 * kBits;
  return static_cast<size_t>((code * 0x9e3779b97f4a7c15u) >> 24);
}

/// Bits of the cells of a brick whose coordinates lie in the ranges [low, high] along each axis.
uint64_t BitsWithin(const CellAt& low, const CellAt& high) {
  const auto axis = [&](size_t a, uint64_t first, int step) {
    uint64_t bits = 0;
    for (int i = low[a]; i <= high[a]; ++i) bits |= first << step * i;
    return bits;
  };
  return axis(0, 0x1111111111111111u, 1) & axis(1, 0x000f000f000f000fu, kBrickSide) &
         axis(2, 0x000000000000ffffu, kBrickSide * kBrickSide);
}

/// Of the 5 x 5 x 5 cells about one: the bits in each of the two by two by two bricks, the first of which
/// holds their least corner at `corner` (in [0, 4) along each axis).
std::array<uint64_t, 8> ReachBits(const CellAt& corner) {
  std::array<uint64_t, 8> bits;
  for (size_t i = 0; i < 8; ++i) {
    CellAt low, high;
    for (size_t a = 0; a < 3; ++a) {
      const bool second = (i >> a & 1) != 0;
      low[a] = second ? 0 : corner[a];
      high[a] = second ? corner[a] + 2 * kReach - kBrickSide : kBrickSide - 1;
    }
    bits[i] = BitsWithin(low, high);
  }
  return bits;
}

std::array<std::array<uint64_t, 8>, 64> AllReachBits() {
  std::array<std::array<uint64_t, 8>, 64> all;
  for (int i = 0; i < 64; ++i) all[static_cast<size_t>(i)] = ReachBits({i & 3, i >> 2 & 3, i >> 4});
  return all;
}

}  // namespace

const OverlapCloud::Brick* OverlapCloud::Find(const CellAt& at) const {
  const size_t mask = slots_.size() - 1;
  for (size_t slot = Hash(at) & mask; slots_[slot] != 0; slot = (slot + 1) & mask) {
    const Brick& brick = bricks_[slots_[slot] - 1];
    if (brick.at == at) return &brick;
  }
  return nullptr;
}

OverlapCloud::Brick* OverlapCloud::FindOrCreate(const CellAt& at) {
  if (const Brick* const found = Find(at)) return &bricks_[static_cast<size_t>(found - bricks_.data())];
  bricks_.push_back({at, 0, {}});
  if (2 * bricks_.size() > slots_.size()) {
    Grow();
  } else {
    size_t slot = Hash(at) & (slots_.size() - 1);
    while (slots_[slot] != 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<uint32_t>(bricks_.size());
  }
  return &bricks_.back();
}

void OverlapCloud::Grow() {
  slots_.assign(2 * slots_.size(), 0);
  for (size_t i = 0; i < bricks_.size(); ++i) {
    size_t slot = Hash(bricks_[i].at) & (slots_.size() - 1);
    while (slots_[slot] != 0) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<uint32_t>(i + 1);
  }
}

void OverlapCloud::Add(std::span<const Vec3f> points) {
  for (const Vec3f& p : points) {
    const CellAt cell = CellOf(p, filter_m_);
    Brick* const brick = FindOrCreate({cell[0] >> kBrickBits, cell[1] >> kBrickBits, cell[2] >> kBrickBits});
    const uint64_t bit = BitOf(cell);
    if ((brick->held & bit) != 0) continue;
    brick->points.insert(brick->points.begin() + std::popcount(brick->held & (bit - 1)), p);
    brick->held |= bit;
    ++size_;
  }
}

bool OverlapCloud::HasNear(const Vec3f& p, Neighbourhood* around) const {
  static const std::array<std::array<uint64_t, 8>, 64> kReachBits = AllReachBits();
  const CellAt cell = CellOf(p, filter_m_);
  const CellAt low = {cell[0] - kReach, cell[1] - kReach, cell[2] - kReach};
  const CellAt first = {low[0] >> kBrickBits, low[1] >> kBrickBits, low[2] >> kBrickBits};
  if (!around->asked || around->first != first) {
    around->first = first;
    around->asked = true;
    for (int i = 0; i < 8; ++i)
      around->bricks[static_cast<size_t>(i)] =
          Find({first[0] + (i & 1), first[1] + (i >> 1 & 1), first[2] + (i >> 2)});
  }
  const auto& reach = kReachBits[static_cast<size_t>(std::countr_zero(BitOf(low)))];
  size_t own = 0;  // the brick that holds the cell itself, where a near point most often is
  for (size_t a = 0; a < 3; ++a) own |= static_cast<size_t>((cell[a] >> kBrickBits) != first[a]) << a;
  const float limit_sq = 3.0f * filter_m_ * filter_m_;
  for (size_t n = 0; n < 8; ++n) {
    const size_t i = n ^ own;
    const Brick* const brick = around->bricks[i];
    if (brick == nullptr) continue;
    for (uint64_t bits = brick->held & reach[i]; bits != 0; bits &= bits - 1) {
      const int place = std::popcount(brick->held & ((bits & -bits) - 1));
      if ((brick->points[static_cast<size_t>(place)] - p).squaredNorm() < limit_sq) return true;
    }
  }
  return false;
}

std::vector<Vec3f> OverlapCloud::Points() const {
  std::vector<std::pair<CellAt, Vec3f>> order;
  for (const Brick& brick : bricks_) {
    for (const Vec3f& p : brick.points) {
      const CellAt cell = CellOf(p, filter_m_);
      order.push_back({{cell[2], cell[1], cell[0]}, p});
    }
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vec3f> points;
  points.reserve(order.size());
  for (const auto& [cell, p] : order) points.push_back(p);
  return points;
}

double OverlapCloud::ShareNear(std::span<const Vec3f> points, double above) const {
  const auto all = static_cast<double>(points.size());
  Neighbourhood around;
  size_t near = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (static_cast<double>(near + points.size() - i) / all <= above) return 0.0;
    near += HasNear(points[i], &around);
  }
  const double share = points.empty() ? 0.0 : static_cast<double>(near) / all;
  return share > above ? share : 0.0;
}

std::vector<Vec3f> FilterCloud(std::span<const Vec3f> points, double filter_m) {
  VoxelFilter filter(filter_m);
  std::vector<Vec3f> kept;
  for (const Vec3f& p : points) {
    if (filter.Insert(p)) kept.push_back(p);
  }
  return kept;
}

}  // namespace atlas::mapping
