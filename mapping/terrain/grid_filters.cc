#include "mapping/terrain/grid_filters.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace atlas::mapping::terrain {
namespace {

size_t At(int row, int col, int cols) {
  return static_cast<size_t>(row) * static_cast<size_t>(cols) + static_cast<size_t>(col);
}

/// Distance along the column to the nearest set cell, capped at `cap`.
std::vector<int16_t> ColumnDistance(const Mask& mask, int rows, int cols, int16_t cap) {
  std::vector<int16_t> d(mask.size());
  const size_t width = static_cast<size_t>(cols);
  for (int r = 0; r < rows; ++r) {
    int16_t* row = d.data() + At(r, 0, cols);
    const uint8_t* set = mask.data() + At(r, 0, cols);
    const int16_t* above = row - (r > 0 ? width : 0);
    for (size_t c = 0; c < width; ++c) {
      const int16_t next = r > 0 ? std::min<int16_t>(static_cast<int16_t>(above[c] + 1), cap) : cap;
      row[c] = set[c] ? int16_t{0} : next;
    }
  }
  for (int r = rows - 2; r >= 0; --r) {
    int16_t* row = d.data() + At(r, 0, cols);
    const int16_t* below = row + width;
    for (size_t c = 0; c < width; ++c) row[c] = std::min<int16_t>(row[c], static_cast<int16_t>(below[c] + 1));
  }
  return d;
}

template <typename Better>
void SlideRows(const std::vector<float>& in, int rows, int cols, int radius, float empty,
               const Better& better, std::vector<float>* out) {
  const size_t width = static_cast<size_t>(cols), pad = static_cast<size_t>(radius);
  std::vector<float> line(width + 2 * pad, empty);
  for (int r = 0; r < rows; ++r) {
    std::copy_n(in.data() + At(r, 0, cols), width, line.data() + pad);
    float* to = out->data() + At(r, 0, cols);
    std::copy_n(line.data(), width, to);
    for (size_t k = 1; k <= 2 * pad; ++k) {
      for (size_t c = 0; c < width; ++c) to[c] = better(to[c], line[c + k]);
    }
  }
}

template <typename Better>
std::vector<float> Slide(const std::vector<float>& in, int rows, int cols, int radius, float empty,
                         const Better& better) {
  std::vector<float> across(in.size()), out(in.size());
  SlideRows(in, rows, cols, radius, empty, better, &across);
  const size_t width = static_cast<size_t>(cols);
  for (int r = 0; r < rows; ++r) {
    float* to = out.data() + At(r, 0, cols);
    std::fill_n(to, width, empty);
    for (int k = std::max(0, r - radius); k <= std::min(rows - 1, r + radius); ++k) {
      const float* from = across.data() + At(k, 0, cols);
      for (size_t c = 0; c < width; ++c) to[c] = better(to[c], from[c]);
    }
  }
  return out;
}

/// Sums over a window, with offsets (x along the row, y along the column) from its centre in blocks.
enum Moment : size_t { kN, kX, kY, kXX, kXY, kYY, kZ, kXZ, kYZ, kZZ, kMoments };
/// The same along one row of blocks only.
enum RowSum : size_t { kRowN, kRowX, kRowXX, kRowZ, kRowXZ, kRowZZ, kRowSums };
using RowImages = std::array<std::vector<float>, kRowSums>;

/// Blocks' count, sum and sum of squares of the valid heights, relative to `datum`.
struct BlockSums {
  std::vector<float> n, z, zz;
};

BlockSums SumBlocks(const std::vector<float>& height, const Mask& valid, int rows, int cols, int block_rows,
                    int block_cols, float datum) {
  const size_t count = static_cast<size_t>(block_rows) * static_cast<size_t>(block_cols);
  BlockSums sums{std::vector<float>(count), std::vector<float>(count), std::vector<float>(count)};
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const size_t i = At(r, c, cols), b = At(r / 2, c / 2, block_cols);
      if (!valid[i]) continue;
      const float z = height[i] - datum;
      sums.n[b] += 1.0f;
      sums.z[b] += z;
      sums.zz[b] += z * z;
    }
  }
  return sums;
}

/// Adds `weight` * from[c + shift] to out[c].
void AddShifted(const float* from, float weight, int shift, int cols, float* out) {
  const int begin = std::max(0, -shift), end = std::min(cols, cols - shift);
  for (int c = begin; c < end; ++c) out[c] += weight * from[c + shift];
}

RowImages SumAlongRows(const BlockSums& sums, int rows, int cols, int radius) {
  RowImages across;
  for (auto& image : across) image.assign(sums.n.size(), 0.0f);
  for (int r = 0; r < rows; ++r) {
    const size_t at = At(r, 0, cols);
    for (int dx = -radius; dx <= radius; ++dx) {
      const float x = static_cast<float>(dx);
      AddShifted(&sums.n[at], 1.0f, dx, cols, &across[kRowN][at]);
      AddShifted(&sums.n[at], x, dx, cols, &across[kRowX][at]);
      AddShifted(&sums.n[at], x * x, dx, cols, &across[kRowXX][at]);
      AddShifted(&sums.z[at], 1.0f, dx, cols, &across[kRowZ][at]);
      AddShifted(&sums.z[at], x, dx, cols, &across[kRowXZ][at]);
      AddShifted(&sums.zz[at], 1.0f, dx, cols, &across[kRowZZ][at]);
    }
  }
  return across;
}

void SumDownColumns(const RowImages& across, int row, int rows, int cols, int radius,
                    std::array<std::vector<float>, kMoments>* down) {
  for (auto& line : *down) line.assign(static_cast<size_t>(cols), 0.0f);
  for (int dy = std::max(-radius, -row); dy <= std::min(radius, rows - 1 - row); ++dy) {
    const size_t at = At(row + dy, 0, cols);
    const float y = static_cast<float>(dy);
    const auto add = [&](RowSum image, float weight, Moment moment) {
      AddShifted(&across[image][at], weight, 0, cols, (*down)[moment].data());
    };
    add(kRowN, 1.0f, kN);
    add(kRowX, 1.0f, kX);
    add(kRowN, y, kY);
    add(kRowXX, 1.0f, kXX);
    add(kRowX, y, kXY);
    add(kRowN, y * y, kYY);
    add(kRowZ, 1.0f, kZ);
    add(kRowXZ, 1.0f, kXZ);
    add(kRowZ, y, kYZ);
    add(kRowZZ, 1.0f, kZZ);
  }
}

void SolvePlane(const float* const m[kMoments], size_t c, double block_m, float datum, PlaneFits* fits,
                size_t at) {
  const double n = m[kN][c];
  if (n < 6.0) return;
  const double x = m[kX][c] / n, y = m[kY][c] / n, z = m[kZ][c] / n;
  const double xx = m[kXX][c] / n - x * x, xy = m[kXY][c] / n - x * y, yy = m[kYY][c] / n - y * y;
  const double xz = m[kXZ][c] / n - x * z, yz = m[kYZ][c] / n - y * z, zz = m[kZZ][c] / n - z * z;
  // Cells nearly in a line determine no plane: then level.
  const double det = xx * yy - xy * xy;
  const bool spread = det > 0.02;
  const double a = spread ? (xz * yy - yz * xy) / det : 0.0;
  const double b = spread ? (yz * xx - xz * xy) / det : 0.0;
  fits->height_m[at] = static_cast<float>(z - a * x - b * y + datum);
  fits->slope_rad[at] = static_cast<float>(std::atan(std::sqrt(a * a + b * b) / block_m));
  fits->roughness_m[at] = static_cast<float>(std::sqrt(std::max(0.0, zz - a * xz - b * yz)));
}

}  // namespace

std::vector<int16_t> SquaredDistance(const Mask& mask, int rows, int cols, int radius) {
  assert(radius < 120);
  const int16_t cap = static_cast<int16_t>(radius + 1);
  const int16_t far = static_cast<int16_t>(cap * cap);
  std::vector<int16_t> out = ColumnDistance(mask, rows, cols, cap);
  const size_t width = static_cast<size_t>(cols), pad = static_cast<size_t>(radius);
  std::vector<int16_t> line(width + 2 * pad, far);
  for (int r = 0; r < rows; ++r) {
    int16_t* row = out.data() + At(r, 0, cols);
    for (size_t c = 0; c < width; ++c) line[c + pad] = static_cast<int16_t>(row[c] * row[c]);
    std::fill_n(row, width, far);
    for (int dx = -radius; dx <= radius; ++dx) {
      const int16_t* shifted = line.data() + (static_cast<int>(pad) + dx);
      const int16_t dx2 = static_cast<int16_t>(dx * dx);
      for (size_t c = 0; c < width; ++c) {
        row[c] = std::min<int16_t>(row[c], static_cast<int16_t>(shifted[c] + dx2));
      }
    }
  }
  return out;
}

std::vector<float> SlidingRange(const std::vector<float>& value, const Mask& valid, int rows, int cols,
                                int radius) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<float> low(value), high(value);
  for (size_t i = 0; i < value.size(); ++i) {
    if (valid[i]) continue;
    low[i] = kInf;
    high[i] = -kInf;
  }
  low = Slide(low, rows, cols, radius, kInf, [](float a, float b) { return a < b ? a : b; });
  high = Slide(high, rows, cols, radius, -kInf, [](float a, float b) { return a > b ? a : b; });
  for (size_t i = 0; i < value.size(); ++i) high[i] = high[i] >= low[i] ? high[i] - low[i] : 0.0f;
  return high;
}

std::vector<float> SlidingMax(const std::vector<float>& value, const Mask& valid, int rows, int cols,
                              int radius) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<float> high(value);
  for (size_t i = 0; i < value.size(); ++i) high[i] = valid[i] ? value[i] : -kInf;
  return Slide(high, rows, cols, radius, -kInf, [](float a, float b) { return a > b ? a : b; });
}

std::vector<float> Ridges(const std::vector<float>& value, const Mask& valid, int rows, int cols,
                          int radius) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<float> opened(value);
  for (size_t i = 0; i < value.size(); ++i) opened[i] = valid[i] ? value[i] : kInf;
  opened = Slide(opened, rows, cols, radius, kInf, [](float a, float b) { return a < b ? a : b; });
  for (float& v : opened) v = v == kInf ? -kInf : v;
  opened = Slide(opened, rows, cols, radius, -kInf, [](float a, float b) { return a > b ? a : b; });
  std::vector<float> ridge(value.size(), 0.0f);
  for (size_t i = 0; i < value.size(); ++i) {
    if (valid[i]) ridge[i] = std::max(0.0f, value[i] - opened[i]);
  }
  return ridge;
}

PlaneFits FitPlanes(const std::vector<float>& height_m, const Mask& valid, int rows, int cols, double cell_m,
                    int radius_blocks) {
  PlaneFits fits;
  fits.rows = (rows + 1) / 2;
  fits.cols = (cols + 1) / 2;
  const size_t width = static_cast<size_t>(fits.cols), count = width * static_cast<size_t>(fits.rows);
  fits.height_m.assign(count, std::numeric_limits<float>::quiet_NaN());
  fits.slope_rad.assign(count, 0.0f);
  fits.roughness_m.assign(count, 0.0f);

  float datum = 0.0f;  // any valid height: keeps the squares small
  for (size_t i = 0; i < valid.size(); ++i) {
    if (valid[i]) {
      datum = height_m[i];
      break;
    }
  }
  const BlockSums sums = SumBlocks(height_m, valid, rows, cols, fits.rows, fits.cols, datum);

  const RowImages across = SumAlongRows(sums, fits.rows, fits.cols, radius_blocks);
  std::array<std::vector<float>, kMoments> down;
  const float* moments[kMoments];
  for (int r = 0; r < fits.rows; ++r) {
    SumDownColumns(across, r, fits.rows, fits.cols, radius_blocks, &down);
    for (size_t k = 0; k < kMoments; ++k) moments[k] = down[k].data();
    for (size_t c = 0; c < width; ++c) {
      SolvePlane(moments, c, 2.0 * cell_m, datum, &fits, At(r, static_cast<int>(c), fits.cols));
    }
  }
  return fits;
}

}  // namespace atlas::mapping::terrain
