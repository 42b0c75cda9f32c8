// Window filters on row-major images: exact distances, sliding ranges, plane fits.
#pragma once

#include <cstdint>
#include <vector>

namespace atlas::mapping::terrain {

using Mask = std::vector<uint8_t>;

/// Squared Euclidean distance, in cells, from each cell to the nearest nonzero cell of `mask`; exact up to
/// `radius` cells, and (radius + 1)^2 where there is none that near. @pre radius < 120.
std::vector<int16_t> SquaredDistance(const Mask& mask, int rows, int cols, int radius);

/// Highest minus lowest value among the valid cells of the (2 radius + 1)^2 square about each cell; 0 where
/// none.
std::vector<float> SlidingRange(const std::vector<float>& value, const Mask& valid, int rows, int cols,
                                int radius);

/// Highest value among the valid cells of the (2 radius + 1)^2 square about each cell; -infinity where none.
std::vector<float> SlidingMax(const std::vector<float>& value, const Mask& valid, int rows, int cols,
                              int radius);

/// How far each valid cell stands out above what is left of the image once everything narrower than
/// 2 radius + 1 cells along either axis is taken off (value minus its morphological opening); 0 elsewhere.
std::vector<float> Ridges(const std::vector<float>& value, const Mask& valid, int rows, int cols, int radius);

/// Least-squares plane through the valid heights of a square about each block of 2 x 2 cells.
struct PlaneFits {
  int rows = 0, cols = 0;       ///< in blocks; block (r, c) holds cells (2r..2r+1, 2c..2c+1)
  std::vector<float> height_m;  ///< of the plane at the block's centre; NaN where too few cells
  std::vector<float> slope_rad;
  std::vector<float> roughness_m;  ///< rms distance in height from the plane
};
PlaneFits FitPlanes(const std::vector<float>& height_m, const Mask& valid, int rows, int cols, double cell_m,
                    int radius_blocks);

}  // namespace atlas::mapping::terrain
