#include "mapping/terrain/gap_filling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atlas::mapping::terrain {
namespace {

constexpr int kMinCrossings = 3;    ///< fewer may be noise at a rim
constexpr int kManyCrossings = 30;  ///< in 5 x 5 cells: bars that stop one ray in four would have shown
constexpr int kRaysPerGroundReturn =
    10;  ///< of the rays that meet a cell of a grating, at most, for one that its bars stop
constexpr float kSmoothGate_m = 0.04f;  ///< neighbours less apart are averaged; a kerb keeps its edge
constexpr float kAny_m = std::numeric_limits<float>::infinity();
constexpr int kRelaxations = 2;   ///< of interpolated heights; most gaps are a cell or two wide
constexpr int kSpeckleCells = 8;  ///< of 5 x 5, at least, for ground amid crossings to count

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
  const size_t count = ground.kind.size(), width = static_cast<size_t>(ground.side);
  Mask measured(count, 0);
  uint8_t* const out = measured.data();
  const CellKind* const kind = ground.kind.data();
  const uint16_t* const support = ground.support.data();
  const uint16_t* const crossings = ground.crossings.data();
  for (size_t i = 0; i < count; ++i) {
    out[i] = (kind[i] == CellKind::kGround) & (support[i] * kRaysPerGroundReturn >= crossings[i]);
  }
  // A few returns amid many crossings are no grating: a handrail that goes down a stairwell.
  Mask kept(measured);
  for (size_t i = 2 * width; i + 2 * width < count; ++i) {
    if (crossings[i] < kMinCrossings || out[i] == 0 || i % width < 2 || i % width + 2 >= width) continue;
    int near = 0;
    for (size_t j = i - 2 * width - 2; j <= i + 2 * width; j += width) {
      for (size_t k = j; k < j + 5; ++k) near += out[k];
    }
    kept[i] = near >= kSpeckleCells;
  }
  return kept;
}

/// Opens what is covered by discs of this radius (in cells) that touch no cell of `closed` and whose centre
/// is `eligible`.
template <typename Eligible>
void OpenByDisc(const Mask& closed, const std::vector<int16_t>& distance2_closed, int side,
                double radius_cells, const Eligible& eligible, Mask* open) {
  const int radius2 = static_cast<int>(std::ceil(radius_cells * radius_cells));
  Mask centre(closed.size(), 0);
  const int16_t* const distance2 = distance2_closed.data();
  for (size_t i = 0; i < closed.size(); ++i) {
    if (distance2[i] >= radius2 && eligible(i)) centre[i] = 1;
  }
  // Three quarters of a cell more reaches into the corners of a rectangular hole.
  const double reach = radius_cells + 0.75;
  const int reach2 = static_cast<int>(reach * reach);
  const std::vector<int16_t> d2 = SquaredDistance(centre, side, side, static_cast<int>(std::ceil(reach)));
  const uint8_t* const shut = closed.data();
  const int16_t* const near = d2.data();
  uint8_t* const out = open->data();
  for (size_t i = 0, count = closed.size(); i < count; ++i) {
    out[i] = static_cast<uint8_t>(out[i] | ((shut[i] == 0) & (near[i] <= reach2)));
  }
}

/// Whether so many rays went down about this cell that bars would have stopped some.
bool SeenThrough(const GroundImage& ground, size_t i) {
  if (ground.crossings[i] < kMinCrossings) return false;
  const size_t width = static_cast<size_t>(ground.side), row = i / width, col = i % width;
  if (row < 2 || col < 2 || row + 2 >= width || col + 2 >= width) return false;
  int sum = 0;
  for (size_t r = row - 2; r <= row + 2; ++r) {
    for (size_t c = col - 2; c <= col + 2; ++c) sum += ground.crossings[r * width + c];
  }
  return sum >= kManyCrossings;
}

/// Mean with alike neighbours: noise falls, steps stay. Cells that are not solid pass through.
std::vector<float> Smooth(const std::vector<float>& height, const Mask& solid, int side) {
  const size_t width = static_cast<size_t>(side);
  constexpr float kFar = 1e9f;  // alike to nothing
  std::vector<float> value(height), out(height);
  for (size_t i = 0; i < value.size(); ++i) value[i] = solid[i] ? value[i] : kFar;
  std::vector<float> sum(width), n(width);
  for (size_t r = 1; r + 1 < width; ++r) {
    const float* own = value.data() + r * width;
    for (size_t c = 0; c < width; ++c) {
      sum[c] = 0.0f;
      n[c] = 0.0f;
    }
    for (size_t k = 0; k < 9; ++k) {
      const float* other = value.data() + (r + k / 3 - 1) * width + k % 3;
      for (size_t c = 1; c + 1 < width; ++c) {
        const float z = other[c - 1];
        const float apart = (z - own[c]) * (1.0f / kSmoothGate_m);
        const float weight = std::max(0.0f, 1.0f - apart * apart);
        sum[c] += weight * z;
        n[c] += weight;
      }
    }
    for (size_t c = 1; c + 1 < width; ++c) {
      if (solid[r * width + c]) out[r * width + c] = sum[c] / n[c];
    }
  }
  return out;
}

/// Mean of the solid neighbours of a cell, of those only that are at most `alike_m` above the lowest; NaN
/// where none is solid.
float MeanAbout(const std::vector<float>& height_m, const Mask& solid, size_t i, int side, float alike_m) {
  float lowest = std::numeric_limits<float>::infinity();
  ForNeighbours(i, side, [&](size_t j) {
    if (solid[j]) lowest = std::min(lowest, height_m[j]);
  });
  float sum = 0.0f;
  int n = 0;
  ForNeighbours(i, side, [&](size_t j) {
    if (!solid[j] || height_m[j] > lowest + alike_m) return;
    sum += height_m[j];
    ++n;
  });
  return sum / static_cast<float>(n);
}

/// Cells to fill; at most so many rounds reach their middle.
struct Gaps {
  std::vector<size_t> cells;
  int side, rounds;
};

/// Grows heights from the rim of each gap inwards, then relaxes them. Returns the cells that were reached.
std::vector<size_t> Interpolate(const Gaps& gaps, float alike_m, Mask solid, std::vector<float>* height_m) {
  const int side = gaps.side;
  std::vector<size_t> filled, waiting(gaps.cells);
  for (int round = 0; round < gaps.rounds && !waiting.empty(); ++round) {
    std::vector<std::pair<size_t, float>> grown;
    std::vector<size_t> later;
    for (const size_t i : waiting) {
      const float height = MeanAbout(*height_m, solid, i, side, alike_m);
      if (std::isnan(height)) {
        later.push_back(i);
      } else {
        grown.emplace_back(i, height);
      }
    }
    for (const auto& [i, height] : grown) {
      (*height_m)[i] = height;
      solid[i] = 1;
      filled.push_back(i);
    }
    waiting.swap(later);
  }
  for (int pass = 0; pass < kRelaxations; ++pass) {
    for (const size_t i : filled) (*height_m)[i] = MeanAbout(*height_m, solid, i, side, alike_m);
  }
  return filled;
}

}  // namespace

Support FindSupport(double cell_m, double max_fill_m, const GroundImage& ground) {
  const int side = ground.side;
  Support support;
  support.height_m = ground.height_m;
  support.solid = MeasuredGround(ground);
  support.filled.assign(support.solid.size(), 0);

  Mask closed(support.solid);
  std::transform(closed.begin(), closed.end(), ground.blocked.begin(), closed.begin(),
                 [](uint8_t a, uint8_t b) { return static_cast<uint8_t>(a | b); });
  // Between centres a gap is a cell wider than between edges.
  const double radius = 0.5 * max_fill_m / cell_m + 0.5, seen_radius = 0.25 * max_fill_m / cell_m + 0.25;
  const std::vector<int16_t> d2 =
      SquaredDistance(closed, side, side, static_cast<int>(std::ceil(radius)) + 1);
  support.open.assign(closed.size(), 0);
  OpenByDisc(
      closed, d2, side, radius, [](size_t) { return true; }, &support.open);
  OpenByDisc(
      closed, d2, side, seen_radius, [&](size_t i) { return SeenThrough(ground, i); }, &support.open);

  Gaps gaps{{}, side, static_cast<int>(std::ceil(radius)) + 1};
  for (size_t i = 0; i < closed.size(); ++i) {
    if (!closed[i] && !support.open[i]) gaps.cells.push_back(i);
  }
  support.height_m = Smooth(Smooth(support.height_m, support.solid, side), support.solid, side);
  support.low_m = support.height_m;
  Interpolate(gaps, kSmoothGate_m, support.solid, &support.low_m);
  for (const size_t i : Interpolate(gaps, kAny_m, support.solid, &support.height_m)) {
    support.solid[i] = 1;
    support.filled[i] = 1;
  }
  for (size_t i = 0; i < closed.size(); ++i) support.open[i] = !support.solid[i] && !closed[i];
  return support;
}

}  // namespace atlas::mapping::terrain
