#include "mapping/atlas/submap_index.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;

constexpr double kMostCells = 4e6;  ///< a wider place has wider cells
constexpr float kRounding = 1e-4f;

}  // namespace

void SubmapIndex::Add(const SubmapOutline& outline, const core::Pose& T_map_submap) {
  if (cell_m_ == 0.0) cell_m_ = outline.block_m;
  const Vec3 half = HalfSizeOfTurned(outline.block_m, T_map_submap);
  outline.ForEachBlock([&](const Vec3& center_submap) {
    const Vec3 center = T_map_submap * center_submap;
    bounds_map_.Extend(center - half);
    bounds_map_.Extend(center + half);
    blocks_.push_back({(center - half).cast<float>().array() - kRounding,
                       (center + half).cast<float>().array() + kRounding, submaps_});
  });
  ++submaps_;
}

template <typename Visit>
void SubmapIndex::ForCells(const Block& block, const Visit& visit) const {
  int low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    const auto cell = [&](float m) {
      return std::clamp(static_cast<int>(std::floor(static_cast<double>(m) / cell_m_)) - first_[a], 0,
                        count_[a] - 1);
    };
    low[a] = cell(block.low[a]);
    high[a] = cell(block.high[a]);
  }
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      for (int x = low[0]; x <= high[0]; ++x)
        visit((static_cast<size_t>(z) * static_cast<size_t>(count_[1]) + static_cast<size_t>(y)) *
                  static_cast<size_t>(count_[0]) +
              static_cast<size_t>(x));
    }
  }
}

void SubmapIndex::Build() {
  if (blocks_.empty()) return;
  while ((bounds_map_.Size().array() / cell_m_ + 2.0).prod() > kMostCells) cell_m_ *= 2.0;
  size_t cells = 1;
  for (int a = 0; a < 3; ++a) {
    first_[a] = static_cast<int>(std::floor(bounds_map_.min[a] / cell_m_));
    count_[a] = static_cast<int>(std::floor(bounds_map_.max[a] / cell_m_)) - first_[a] + 1;
    cells *= static_cast<size_t>(count_[a]);
  }
  // Two passes over the blocks, which come submap by submap: a cell counts each submap once.
  std::vector<uint16_t> last(cells, 0);  // the submap that a cell was counted for last, from 1
  begin_.assign(cells + 1, 0);
  const auto once = [&](const Block& block, const auto& visit) {
    ForCells(block, [&](size_t cell) {
      const auto number = static_cast<uint16_t>(block.submap + 1);
      if (std::exchange(last[cell], number) != number) visit(cell);
    });
  };
  for (const Block& block : blocks_) once(block, [&](size_t cell) { ++begin_[cell + 1]; });
  for (size_t cell = 0; cell < cells; ++cell) begin_[cell + 1] += begin_[cell];
  members_.resize(begin_.back());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  std::fill(last.begin(), last.end(), uint16_t{0});
  for (const Block& block : blocks_) once(block, [&](size_t cell) { members_[next[cell]++] = block.submap; });
  blocks_ = {};
}

std::span<const uint16_t> SubmapIndex::At(const Vec3& p_map) const {
  if (members_.empty()) return {};
  size_t cell = 0;
  for (int a = 2; a >= 0; --a) {
    const double at = std::floor(p_map[a] / cell_m_) - first_[a];
    if (!(at >= 0.0 && at < count_[a])) return {};
    cell = cell * static_cast<size_t>(count_[a]) + static_cast<size_t>(at);
  }
  return std::span(members_).subspan(begin_[cell], begin_[cell + 1] - begin_[cell]);
}

}  // namespace atlas::mapping
