#include "planner/terrain/gap_filling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atlas::planner::terrain {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kMinCrossings = 3;     ///< fewer may be noise at a rim
constexpr float kSolidShare = 0.1f;  ///< of the rays that meet a cell of a grating end on its bars, at least
constexpr float kSmoothGate_m = 0.03f;  ///< neighbours this alike are averaged; a kerb keeps its edge
constexpr float kConsistent_m =
    0.06f;                             ///< heights about a filled cell that differ by more leave it uncertain
constexpr float kSpeckleShare = 0.3f;  ///< of the neighbourhood, for ground amid crossings to count

/// Calls visit(j) for the valid 8-neighbours j of cell i; the outermost ring has none.
template <typename Visit>
void ForNeighbours(size_t i, int side, const Visit& visit) {
  const size_t width = static_cast<size_t>(side), row = i / width, col = i % width;
  if (row == 0 || col == 0 || row + 1 == width || col + 1 == width) return;
  for (size_t r = row - 1; r <= row + 1; ++r) {
    for (size_t c = col - 1; c <= col + 1; ++c) {
      if (r != row || c != col) visit(r * width + c);
    }
  }
}

/// Ground whose returns are not a vanishing share of the rays that met the cell.
Mask MeasuredGround(const GroundImage& ground) {
  Mask measured(ground.kind.size(), 0);
  for (size_t i = 0; i < measured.size(); ++i) {
    measured[i] =
        ground.kind[i] == CellKind::kGround &&
        (static_cast<float>(ground.support[i]) >= kSolidShare * static_cast<float>(ground.crossings[i]));
  }
  // A few returns amid many crossings are no grating: a handrail that goes down a stairwell.
  Mask kept(measured);
  for (int r = 2; r < ground.side - 2; ++r) {
    for (int c = 2; c < ground.side - 2; ++c) {
      const size_t i = ground.Index(r, c);
      if (!measured[i] || ground.crossings[i] < kMinCrossings) continue;
      int near = 0;
      for (int rr = r - 2; rr <= r + 2; ++rr) {
        for (int cc = c - 2; cc <= c + 2; ++cc) near += measured[ground.Index(rr, cc)];
      }
      kept[i] = static_cast<float>(near) >= 25.0f * kSpeckleShare;
    }
  }
  return kept;
}

/// Cells of `gap` covered by discs of this radius (in cells) that are centred on a cell of `gap` for which
/// `eligible` holds and that touch no cell of `closed`.
template <typename Eligible>
void OpenByDisc(const Mask& closed, const std::vector<int16_t>& distance2_closed, int side,
                double radius_cells, const Eligible& eligible, Mask* open) {
  Mask centre(closed.size(), 0);
  for (size_t i = 0; i < closed.size(); ++i) {
    centre[i] = !closed[i] && distance2_closed[i] >= radius_cells * radius_cells && eligible(i);
  }
  // Three quarters of a cell more reaches into the corners of a rectangular hole.
  const double reach = radius_cells + 0.75;
  const std::vector<int16_t> d2 = SquaredDistance(centre, side, side, static_cast<int>(std::ceil(reach)));
  for (size_t i = 0; i < closed.size(); ++i) {
    if (!closed[i] && d2[i] <= reach * reach) (*open)[i] = 1;
  }
}

/// Mean with alike neighbours: noise falls, steps stay.
std::vector<float> Smooth(const std::vector<float>& height, const Mask& solid, int side) {
  std::vector<float> out(height);
  for (int r = 1; r + 1 < side; ++r) {
    for (int c = 1; c + 1 < side; ++c) {
      const size_t i = static_cast<size_t>(r) * static_cast<size_t>(side) + static_cast<size_t>(c);
      if (!solid[i]) continue;
      float sum = 0.0f, n = 0.0f;
      ForNeighbours(i, side, [&](size_t j) {
        const float alike = solid[j] && std::abs(height[j] - height[i]) <= kSmoothGate_m ? 1.0f : 0.0f;
        sum += alike * (solid[j] ? height[j] : 0.0f);
        n += alike;
      });
      out[i] = (2.0f * height[i] + sum) / (2.0f + n);
    }
  }
  return out;
}

/// Grows heights from the rim of each gap inwards, then relaxes them; returns the cells that got one.
std::vector<size_t> Interpolate(const std::vector<size_t>& gaps, int side, int rounds, Support* support) {
  std::vector<size_t> filled, waiting(gaps);
  for (int round = 0; round < rounds && !waiting.empty(); ++round) {
    std::vector<std::pair<size_t, float>> grown;
    std::vector<size_t> later;
    for (const size_t i : waiting) {
      float sum = 0.0f;
      int n = 0;
      ForNeighbours(i, side, [&](size_t j) {
        if (!support->solid[j]) return;
        sum += support->height_m[j];
        ++n;
      });
      if (n > 0) {
        grown.emplace_back(i, sum / static_cast<float>(n));
      } else {
        later.push_back(i);
      }
    }
    for (const auto& [i, height] : grown) {
      support->height_m[i] = height;
      support->solid[i] = 1;
      filled.push_back(i);
    }
    waiting.swap(later);
  }
  for (int pass = 0; pass < 6; ++pass) {
    for (const size_t i : filled) {
      float sum = 0.0f;
      int n = 0;
      ForNeighbours(i, side, [&](size_t j) {
        if (!support->solid[j]) return;
        sum += support->height_m[j];
        ++n;
      });
      if (n > 0) support->height_m[i] = sum / static_cast<float>(n);
    }
  }
  return filled;
}

}  // namespace

Support FindSupport(double cell_m, double max_fill_m, const GroundImage& ground) {
  const int side = ground.side;
  Support support;
  support.height_m = ground.height_m;
  support.solid = MeasuredGround(ground);
  support.uncertain.assign(support.solid.size(), 0);

  Mask closed(support.solid);
  for (size_t i = 0; i < closed.size(); ++i) closed[i] |= ground.blocked[i];
  // Between centres a gap is a cell wider than between edges.
  const double radius = 0.5 * max_fill_m / cell_m + 0.5, seen_radius = 0.25 * max_fill_m / cell_m + 0.25;
  const std::vector<int16_t> d2 =
      SquaredDistance(closed, side, side, static_cast<int>(std::ceil(radius)) + 1);
  support.open.assign(closed.size(), 0);
  OpenByDisc(
      closed, d2, side, radius, [](size_t) { return true; }, &support.open);
  OpenByDisc(
      closed, d2, side, seen_radius,
      [&](size_t i) { return ground.crossings[i] >= kMinCrossings || ground.kind[i] == CellKind::kBelow; },
      &support.open);

  std::vector<size_t> gaps;
  for (size_t i = 0; i < closed.size(); ++i) {
    if (!closed[i] && !support.open[i]) gaps.push_back(i);
  }
  support.height_m = Smooth(Smooth(support.height_m, support.solid, side), support.solid, side);
  const std::vector<size_t> filled =
      Interpolate(gaps, side, static_cast<int>(std::ceil(radius)) + 1, &support);
  const std::vector<float> relief = SlidingRange(support.height_m, support.solid, side, side, 2);
  for (const size_t i : filled) support.uncertain[i] = relief[i] > kConsistent_m;
  for (size_t i = 0; i < closed.size(); ++i) support.open[i] = !support.solid[i] && !closed[i];
  return support;
}

}  // namespace atlas::planner::terrain
