#include "mapping/integrator/projection/beam_grid.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/errors.h"

namespace atlas::mapping {
namespace {

constexpr double kLeastPitchRad = 1e-5;

/// Row coordinate of an elevation: linear between beams, going on by the last pitch outside.
double RowOfElevation(const std::vector<double>& descending, double elevation) {
  const auto rows = descending.size();
  size_t below = 1;  // the first row, from 1, that lies below `elevation`; the last at most
  while (below + 1 < rows && descending[below] > elevation) ++below;
  const double upper = descending[below - 1], lower = descending[below];
  return static_cast<double>(below - 1) + (upper - elevation) / (upper - lower);
}

/// Rows go on so far outside the grid, so that they grow evenly over cubes that its edge cuts.
constexpr double kBeyondRad = 0.15;

void FillRowTable(const std::vector<double>& descending, BeamGrid* grid) {
  const size_t last = descending.size() - 1;
  const double above = std::max(kBeyondRad, descending[0] - descending[1]);
  const double below = std::max(kBeyondRad, descending[last - 1] - descending[last]);
  const double top = std::min(descending[0] + above, 0.5 * core::kPi);
  const double bottom = std::max(descending[last] - below, -0.5 * core::kPi);
  const double sin_min = std::sin(bottom), sin_max = std::sin(top);
  grid->sin_min = static_cast<float>(sin_min);
  grid->sin_max = static_cast<float>(sin_max);
  grid->intervals_per_sin = static_cast<float>(BeamGrid::kTableIntervals / (sin_max - sin_min));
  grid->row_of_sin.resize(BeamGrid::kTableIntervals + 1);
  for (int i = 0; i <= BeamGrid::kTableIntervals; ++i) {
    const double sine = std::clamp(sin_min + (sin_max - sin_min) * i / BeamGrid::kTableIntervals, -1.0, 1.0);
    grid->row_of_sin[static_cast<size_t>(i)] =
        static_cast<float>(RowOfElevation(descending, std::asin(sine)));
  }
}

/// Least squares over the table's range, and whether that is good enough.
void FitRows(const std::vector<double>& descending, BeamGrid* grid) {
  constexpr int kSamples = 512;
  constexpr auto kTerms = static_cast<Eigen::Index>(std::tuple_size_v<decltype(BeamGrid::row_terms)>);
  const auto first = static_cast<double>(grid->sin_min), last = static_cast<double>(grid->sin_max);
  Eigen::MatrixXd powers(kSamples, kTerms + 1);
  Eigen::VectorXd rows(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double sine = std::clamp(first + (last - first) * i / (kSamples - 1), -1.0, 1.0);
    powers(i, 0) = 1.0;
    double power = sine;
    for (Eigen::Index k = 1; k <= kTerms; ++k, power *= sine * sine) powers(i, k) = power;
    rows(i) = RowOfElevation(descending, std::asin(sine));
  }
  const Eigen::VectorXd terms = powers.colPivHouseholderQr().solve(rows);
  grid->polynomial = (powers * terms - rows).cwiseAbs().maxCoeff() < BeamGrid::kWorstFit;
  grid->row_of_level = static_cast<float>(terms(0));
  for (Eigen::Index k = 0; k < kTerms; ++k) {
    grid->row_terms[static_cast<size_t>(k)] = static_cast<float>(terms(k + 1));
  }
}

void FillRows(const std::vector<double>& descending, BeamGrid* grid) {
  const size_t rows = descending.size();
  for (size_t row = 0; row < rows; ++row) {
    const double above = row > 0 ? descending[row - 1] - descending[row] : 0.0;
    const double under = row + 1 < rows ? descending[row] - descending[row + 1] : 0.0;
    const double pitch = row == 0 ? under : row + 1 == rows ? above : 0.5 * (above + under);
    grid->elevation_rad.push_back(static_cast<float>(descending[row]));
    grid->row_pitch_rad.push_back(static_cast<float>(pitch));
    grid->cos_elevation.push_back(static_cast<float>(std::cos(descending[row])));
    if (row > 0) grid->min_pitch_rad = std::min(grid->min_pitch_rad, above);
  }
  grid->mean_row_pitch_rad = (descending.front() - descending.back()) / static_cast<double>(rows - 1);
}

}  // namespace

BeamGrid MakeBeamGrid(const core::LidarModel& lidar) {
  const std::string name = "LiDAR '" + lidar.name + "': ";
  if (lidar.rows() < 2 || lidar.rows() > 1024) throw core::InputError(name + "needs 2 to 1024 rows of beams");
  std::vector<double> descending = lidar.elevation_rad;
  std::sort(descending.rbegin(), descending.rend());
  for (size_t row = 0; row < descending.size(); ++row) {
    if (!(std::abs(descending[row]) <= 0.5 * core::kPi)) {
      throw core::InputError(name + "beam elevation outside +-90 degrees");
    }
    if (row > 0 && descending[row - 1] - descending[row] < kLeastPitchRad) {
      throw core::InputError(name + "two beams have the same elevation");
    }
  }
  BeamGrid grid;
  grid.rows = lidar.rows();
  grid.columns =
      lidar.columns > 0 ? static_cast<int>(std::lround(2.0 * core::kPi / std::abs(lidar.StepRad()))) : 0;
  if (grid.columns < 16 || grid.columns > 16384) {
    throw core::InputError(name + "needs 16 to 16384 columns a turn");
  }
  if (static_cast<size_t>(grid.rows) * static_cast<size_t>(grid.columns) > BeamGrid::kMostCells) {
    throw core::InputError(fmt::format("{}{} x {} beams a turn are more than {}", name, grid.rows,
                                       grid.columns, BeamGrid::kMostCells));
  }
  grid.column_pitch_rad = 2.0 * core::kPi / grid.columns;
  grid.clockwise = lidar.StepRad() < 0.0;
  grid.min_pitch_rad = grid.column_pitch_rad;
  const double turn = (lidar.first_azimuth_rad + core::kPi) / grid.column_pitch_rad;
  grid.phase_rad = -core::kPi + (turn - std::floor(turn)) * grid.column_pitch_rad;
  FillRows(descending, &grid);
  FillRowTable(descending, &grid);
  FitRows(descending, &grid);
  return grid;
}

}  // namespace atlas::mapping
