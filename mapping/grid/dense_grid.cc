#include "mapping/grid/dense_grid.h"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "core/errors.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;

constexpr double kMaxVoxels = 4e8;
/// Of kOccupiedProbability; the negative is kFreeProbability's.
const double kStateLogOdds = std::log(kOccupiedProbability / (1.0 - kOccupiedProbability));

/// Walks a ray voxel by voxel and knows when it enters another block of 8^3 voxels, which it can cross in one
/// step. The ray's parameter t is in metres.
class BlockWalk {
 public:
  static constexpr int kSide = 8;

  /// @pre the ray is inside `frame` from `t_begin` to `t_stop`.
  BlockWalk(const GridFrame& frame, const std::array<int, 3>& blocks, const Vec3& origin,
            const Vec3& direction, double t_begin, double t_stop)
      : t_(t_begin), t_stop_(t_stop), t_last_(t_stop - 1e-9) {
    const Vec3 local = (origin + t_begin * direction - frame.box().min) / frame.resolution_m();
    int cell[3];
    for (int a = 0; a < 3; ++a) {
      const int size = frame.size()[static_cast<size_t>(a)];
      cell[a] = std::clamp(static_cast<int>(std::floor(local[a])), 0, size - 1);
      const bool up = direction[a] > 0.0;
      left_[a] = up ? kSide - (cell[a] & 7) : (cell[a] & 7) + 1;
      index_jump_[a] = (up ? 1 : -1) * static_cast<int64_t>(frame.IndexOf(a == 0, a == 1, a == 2));
      block_jump_[a] = (up ? 1 : -1) * (a == 0 ? 1 : a == 1 ? blocks[0] : blocks[0] * blocks[1]);
      if (direction[a] == 0.0) {
        t_next_[a] = t_delta_[a] = std::numeric_limits<double>::infinity();
        per_delta_[a] = 0.0;
        continue;
      }
      const double boundary = frame.box().min[a] + frame.resolution_m() * (cell[a] + (up ? 1 : 0));
      t_next_[a] = (boundary - origin[a]) / direction[a];
      t_delta_[a] = frame.resolution_m() / std::abs(direction[a]);
      per_delta_[a] = 1.0 / t_delta_[a];
    }
    index_ = static_cast<int64_t>(frame.IndexOf(cell[0], cell[1], cell[2]));
    block_ = (cell[0] >> 3) + blocks[0] * ((cell[1] >> 3) + blocks[1] * (cell[2] >> 3));
  }

  size_t index() const { return static_cast<size_t>(index_); }
  size_t block() const { return static_cast<size_t>(block_); }
  double t() const { return t_; }

  /// Calls `visit(index, length_m)` on the voxels up to the end of the block. Returns false when the ray ends
  /// or `visit` returns false, which `stopped` then tells.
  template <typename Visit>
  bool CrossVoxels(bool* stopped, const Visit& visit) {
    int axis = 0;
    // Which boundary comes next is as good as random: selects, not branches.
    do {
      const bool x_first = (t_next_[0] <= t_next_[1]) & (t_next_[0] <= t_next_[2]);
      axis = x_first ? 0 : (t_next_[1] <= t_next_[2] ? 1 : 2);
      const double t_leave = t_next_[axis];
      const bool last = t_leave >= t_last_;
      if (!visit(index(), (last ? t_stop_ : t_leave) - t_)) {
        *stopped = true;
        return false;
      }
      if (last) return false;
      t_ = t_leave;
      index_ += index_jump_[axis];
      t_next_[axis] += t_delta_[axis];
    } while (--left_[axis] > 0);
    EnterBlock(axis);
    return true;
  }

  /// Crosses the rest of the block at once: adds to the voxels met and their length. Returns false when the
  /// ray ends.
  bool CrossBlock(uint32_t* voxels, float* length_m) {
    int axis = 0;
    double t_exit = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
      const double t = t_next_[a] + (left_[a] - 1) * t_delta_[a];
      if (t < t_exit) {
        t_exit = t;
        axis = a;
      }
    }
    const bool last = t_exit >= t_last_;
    const double t_leave = last ? t_stop_ : t_exit;
    *voxels += 1;
    for (int a = 0; a < 3; ++a) {
      // Boundaries before the end; ties on other axes are left to the next block.
      int steps = left_[a];
      if (a != axis || last) {
        const double ahead = ((last ? t_last_ : t_leave) - t_next_[a]) * per_delta_[a];
        steps = ahead > 0.0 ? std::min(static_cast<int>(ahead) + 1, left_[a] - 1) : 0;
      }
      *voxels += static_cast<uint32_t>(steps - (a == axis && !last ? 1 : 0));
      index_ += steps * index_jump_[a];
      t_next_[a] += steps > 0 ? steps * t_delta_[a] : 0.0;
      left_[a] -= steps;
    }
    *length_m += static_cast<float>(t_leave - t_);
    t_ = t_leave;
    if (last) return false;
    EnterBlock(axis);
    return true;
  }

 private:
  void EnterBlock(int axis) {
    left_[axis] = kSide;
    block_ += block_jump_[axis];
  }

  double t_, t_stop_, t_last_;
  double t_next_[3], t_delta_[3], per_delta_[3];
  int left_[3];  ///< steps along each axis until the ray leaves the block
  int64_t index_, block_;
  int64_t index_jump_[3], block_jump_[3];
};

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
    : frame_(region, resolution_m),
      last_free_(kZeroCode + static_cast<int>(std::floor(-kStateLogOdds / kLogOddsStep + 1e-6))),
      first_occupied_(kZeroCode + static_cast<int>(std::ceil(kStateLogOdds / kLogOddsStep - 1e-6))),
      code_(frame_.count(), 0) {
  FillTable();
  for (size_t a = 0; a < 3; ++a) blocks_[a] = (frame_.size()[a] + kBlockSide - 1) / kBlockSide;
  FinishUpdate();
}

void DenseGrid::FillTable() {
  for (int code = 0; code < 256; ++code) {
    Decoded& voxel = table_[static_cast<size_t>(code)];
    if (code < kFirstMeasured) {
      voxel = {0.5f, static_cast<float>(code), CellState::kUnknown};
      continue;
    }
    const double log_odds = (code - kZeroCode) * kLogOddsStep;
    voxel = {static_cast<float>(1.0 / (1.0 + std::exp(-log_odds))), 0.0f,
             code <= last_free_        ? CellState::kFree
             : code >= first_occupied_ ? CellState::kOccupied
                                       : CellState::kUnknown};
  }
}

uint8_t DenseGrid::CodeOf(float log_odds) {
  const int code = kZeroCode + static_cast<int>(std::lround(static_cast<double>(log_odds) / kLogOddsStep));
  return static_cast<uint8_t>(std::clamp(code, kFirstMeasured, 255));
}

void DenseGrid::SetBehindSurface(size_t index, int value) {
  if (Measured(index)) return;
  code_[index] = static_cast<uint8_t>(std::max<int>(code_[index], value));
}

CellState DenseGrid::StateAt(const Vec3& p_map) const {
  const int64_t index = frame_.IndexAt(p_map);
  if (index < 0) return CellState::kUnknown;
  return table_[code_[static_cast<size_t>(index)]].state;
}

RayEnd DenseGrid::Trace(const Vec3& origin_map, const Vec3& direction_map, const TraceLimits& limits,
                        std::vector<RaySample>* samples) const {
  RaySamples met(limits, samples);
  const auto span = frame_.box().Clip(origin_map, direction_map);
  const auto wanted = limits.box_map.Clip(origin_map, direction_map);
  if (!span || !wanted) return RayEnd::kVoid;
  const double begin = std::max(span->first, wanted->first),
               end = std::min({span->second, wanted->second, limits.max_range_m});
  if (begin >= end) return RayEnd::kVoid;
  BlockWalk walk(frame_, blocks_, origin_map, direction_map, begin, end);
  bool occupied = false, on = true;
  const auto visit = [&](size_t index, double length_m) {
    const Decoded& voxel = table_[code_[index]];
    return met.Add({.occupancy = voxel.occupancy,
                    .length_m = static_cast<float>(length_m),
                    .key = index,
                    .behind_surface = limits.behind_surface ? voxel.behind : 0.0f,
                    .state = voxel.state});
  };
  while (on) {
    if (!block_is_free_[walk.block()]) {
      on = walk.CrossVoxels(&occupied, visit);
      continue;
    }
    const size_t first = walk.index();
    uint32_t voxels = 0;
    float length_m = 0.0f;
    on = walk.CrossBlock(&voxels, &length_m);
    met.Add({.occupancy = table_[code_[first]].occupancy,
             .length_m = length_m,
             .key = first,
             .voxels = voxels,
             .state = CellState::kFree});
  }
  return occupied ? RayEnd::kOccupied : RayEnd::kVoid;
}

void DenseGrid::FinishUpdate() {
  block_is_free_.assign(
      static_cast<size_t>(blocks_[0]) * static_cast<size_t>(blocks_[1]) * static_cast<size_t>(blocks_[2]), 0);
  size_t block = 0;
  for (int bz = 0; bz < blocks_[2]; ++bz) {
    for (int by = 0; by < blocks_[1]; ++by) {
      for (int bx = 0; bx < blocks_[0]; ++bx) block_is_free_[block++] = BlockIsFree(bx, by, bz);
    }
  }
}

bool DenseGrid::BlockIsFree(int bx, int by, int bz) const {
  const int begin[3] = {kBlockSide * bx, kBlockSide * by, kBlockSide * bz};
  int end[3];
  for (int a = 0; a < 3; ++a) end[a] = std::min(begin[a] + kBlockSide, frame_.size()[static_cast<size_t>(a)]);
  const uint8_t code = code_[frame_.IndexOf(begin[0], begin[1], begin[2])];
  if (!IsFreeCode(code)) return false;
  const uint8_t like[kBlockSide] = {code, code, code, code, code, code, code, code};
  const auto width = static_cast<size_t>(end[0] - begin[0]);
  for (int k = begin[2]; k < end[2]; ++k) {
    for (int j = begin[1]; j < end[1]; ++j) {
      const uint8_t* const row = &code_[frame_.IndexOf(begin[0], j, k)];
      if (std::memcmp(row, like, width) != 0) return false;
    }
  }
  return true;
}

void DenseGrid::ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const {
  constexpr size_t kGroup = 64;  // most groups hold none: a vectorised maximum passes them
  for (size_t first = 0; first < code_.size(); first += kGroup) {
    const size_t end = std::min(first + kGroup, code_.size());
    uint8_t max = 0;
    for (size_t i = first; i < end; ++i) max = std::max(max, code_[i]);
    if (!IsOccupiedCode(max)) continue;
    for (size_t i = first; i < end; ++i) {
      const Vec3 center = frame_.CenterOf(i);
      if (Occupied(i) && box_map.Contains(center)) visit(center.cast<float>());
    }
  }
}

}  // namespace atlas::mapping
