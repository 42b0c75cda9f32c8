#include "mapping/grid/dense_grid.h"

#include <fmt/format.h>

#include "core/errors.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;

constexpr double kLogOddsStep = 1.0 / 24.0;
constexpr int kZeroCode = 128;  // log-odds 0
constexpr double kMaxVoxels = 4e8;

core::Box3 SnapOut(const core::Box3& box, double cell) {
  return {(box.min / cell).array().floor() * cell, (box.max / cell).array().ceil() * cell};
}

}  // namespace

GridFrame::GridFrame(const core::Box3& region, double resolution_m)
    : resolution_m_(resolution_m),
      inverse_resolution_(1.0 / resolution_m),
      box_(SnapOut(region, resolution_m)) {
  const Vec3 cells = (box_.Size() / resolution_m).array().round();
  if (cells.prod() > kMaxVoxels) {
    throw core::InputError(fmt::format(
        "mapper.resolution_m: {} m over a region of {:.0f} x {:.0f} x {:.0f} m needs {:.1e} "
        "voxels; the limit is {:.0e}",
        resolution_m, box_.Size().x(), box_.Size().y(), box_.Size().z(), cells.prod(), kMaxVoxels));
  }
  for (int a = 0; a < 3; ++a) size_[static_cast<size_t>(a)] = std::max(1, static_cast<int>(cells[a]));
  count_ = static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) * static_cast<size_t>(size_[2]);
}

int64_t GridFrame::IndexAt(const Vec3& p) const {
  const Vec3 local = (p - box_.min) / resolution_m_;
  int cell[3];
  for (int a = 0; a < 3; ++a) {
    cell[a] = static_cast<int>(std::floor(local[a]));
    if (cell[a] < 0 || cell[a] >= size_[static_cast<size_t>(a)]) return -1;
  }
  return static_cast<int64_t>(IndexOf(cell[0], cell[1], cell[2]));
}

Vec3 GridFrame::CenterOf(size_t index) const {
  const auto nx = static_cast<size_t>(size_[0]), ny = static_cast<size_t>(size_[1]);
  const Vec3 cell(static_cast<double>(index % nx), static_cast<double>(index / nx % ny),
                  static_cast<double>(index / nx / ny));
  return box_.min + resolution_m_ * (cell.array() + 0.5).matrix();
}

DenseGrid::DenseGrid(const core::Box3& region, double resolution_m)
    : frame_(region, resolution_m), code_(frame_.count(), 0) {
  for (int code = 0; code < 256; ++code) {
    if (code < kFirstMeasured) {
      table_[static_cast<size_t>(code)] = {0.5f, static_cast<float>(code)};
    } else {
      const double log_odds = (code - kZeroCode) * kLogOddsStep;
      table_[static_cast<size_t>(code)] = {static_cast<float>(1.0 / (1.0 + std::exp(-log_odds))), 0.0f};
    }
  }
  FinishUpdate();
}

void DenseGrid::SetLogOdds(size_t index, float log_odds) {
  const int code = kZeroCode + static_cast<int>(std::lround(static_cast<double>(log_odds) / kLogOddsStep));
  code_[index] = static_cast<uint8_t>(std::clamp(code, kFirstMeasured, 255));
}

void DenseGrid::SetBehindSurface(size_t index, int value) {
  if (Measured(index)) return;
  code_[index] = static_cast<uint8_t>(std::max<int>(code_[index], std::min(value, kFirstMeasured - 1)));
}

CellState DenseGrid::StateAt(const Vec3& p_map) const {
  const int64_t index = frame_.IndexAt(p_map);
  if (index < 0) return CellState::kUnknown;
  const float p = table_[code_[static_cast<size_t>(index)]].occupancy;
  if (p > static_cast<float>(kOccupiedProbability)) return CellState::kOccupied;
  return p < static_cast<float>(kFreeProbability) ? CellState::kFree : CellState::kUnknown;
}

RayEnd DenseGrid::Trace(const Vec3& origin_map, const Vec3& direction_map, double max_range_m,
                        std::vector<RaySample>* samples) const {
  samples->clear();
  const uint8_t* const codes = code_.data();
  const bool stopped =
      frame_.Walk(origin_map, direction_map, max_range_m, [&](size_t index, double t_enter, double t_leave) {
        const Decoded voxel = table_[codes[index]];
        samples->push_back({voxel.occupancy, static_cast<float>(t_leave - t_enter), index, voxel.behind});
        return voxel.occupancy <= static_cast<float>(kOccupiedProbability);
      });
  return stopped ? RayEnd::kOccupied : RayEnd::kVoid;
}

std::vector<Vec3f> DenseGrid::OccupiedCenters() const {
  return occupied_;
}

void DenseGrid::FinishUpdate() {
  occupied_.clear();
  for (size_t i = 0; i < code_.size(); ++i) {
    if (Occupied(i)) occupied_.push_back(frame_.CenterOf(i).cast<float>());
  }
  size_t buckets = 1;
  for (int a = 0; a < 3; ++a) {
    bucket_size_[static_cast<size_t>(a)] =
        std::max(1, static_cast<int>(std::ceil(frame_.box().Size()[a] / bucket_m_)));
    buckets *= static_cast<size_t>(bucket_size_[static_cast<size_t>(a)]);
  }
  const auto bucket_of = [&](const Vec3f& p) {
    size_t index = 0;
    for (int a = 2; a >= 0; --a) {
      const auto n = bucket_size_[static_cast<size_t>(a)];
      const int cell = static_cast<int>((static_cast<double>(p[a]) - frame_.box().min[a]) / bucket_m_);
      index = index * static_cast<size_t>(n) + static_cast<size_t>(std::clamp(cell, 0, n - 1));
    }
    return index;
  };
  bucket_begin_.assign(buckets + 1, 0);
  for (const Vec3f& p : occupied_) ++bucket_begin_[bucket_of(p) + 1];
  for (size_t b = 0; b < buckets; ++b) bucket_begin_[b + 1] += bucket_begin_[b];
  bucket_points_.resize(occupied_.size());
  std::vector<uint32_t> next(bucket_begin_.begin(), bucket_begin_.end() - 1);
  for (const Vec3f& p : occupied_) bucket_points_[next[bucket_of(p)]++] = p;
}

double DenseGrid::DistanceToOccupied(const Vec3& p_map, double limit_m) const {
  double best_squared = limit_m * limit_m;
  int lo[3], hi[3];
  for (int a = 0; a < 3; ++a) {
    const double local = p_map[a] - frame_.box().min[a];
    const int n = bucket_size_[static_cast<size_t>(a)];
    lo[a] = std::clamp(static_cast<int>(std::floor((local - limit_m) / bucket_m_)), 0, n - 1);
    hi[a] = std::clamp(static_cast<int>(std::floor((local + limit_m) / bucket_m_)), 0, n - 1);
  }
  const Vec3f p = p_map.cast<float>();
  for (int k = lo[2]; k <= hi[2]; ++k) {
    for (int j = lo[1]; j <= hi[1]; ++j) {
      const size_t row =
          static_cast<size_t>(bucket_size_[0]) *
          (static_cast<size_t>(j) + static_cast<size_t>(bucket_size_[1]) * static_cast<size_t>(k));
      const uint32_t begin = bucket_begin_[row + static_cast<size_t>(lo[0])];
      const uint32_t end = bucket_begin_[row + static_cast<size_t>(hi[0]) + 1];
      for (uint32_t i = begin; i < end; ++i) {
        best_squared = std::min(best_squared, static_cast<double>((bucket_points_[i] - p).squaredNorm()));
      }
    }
  }
  return std::sqrt(best_squared);
}

}  // namespace atlas::mapping
