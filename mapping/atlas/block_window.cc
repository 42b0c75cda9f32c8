#include "mapping/atlas/block_window.h"

#include <algorithm>

namespace atlas::mapping {
namespace {

constexpr int8_t kUnknownBlock = OccupancyField::Unknown();

using CellTable = std::array<uint16_t, kBlockVoxels>;

template <typename CellOf>
constexpr CellTable MakeCellTable(const CellOf& cell_of) {
  CellTable table{};
  for (int i = 0; i < kBlockVoxels; ++i) table[static_cast<size_t>(i)] = static_cast<uint16_t>(cell_of(i));
  return table;
}
constexpr CellTable kUniformCells = MakeCellTable([](int) { return 0; });
constexpr CellTable kCoarseCells = MakeCellTable([](int i) { return CellOfVoxel(i); });
constexpr CellTable kFineCells = MakeCellTable([](int i) { return i; });

}  // namespace

BlockWindow::Leaf BlockWindow::LeafOf(const NodeKey& at) {
  const OccupancyOctree::Chunk* const chunk = chunks_.Find(at.Up(kBlockLevel));
  if (chunk == nullptr) return {&kUnknownBlock, kUniformCells.data()};
  const int block = BlockIndex(at.x, at.y, at.z);
  switch (chunk->Kind(block)) {
    case BlockKind::kUniform:
      return {&chunk->uniform.log_odds[block], kUniformCells.data()};
    case BlockKind::kCoarse:
      return {tree_.Coarse(*chunk, block).log_odds, kCoarseCells.data()};
    case BlockKind::kFine:
      break;
  }
  return {tree_.Fine(*chunk, block).log_odds, kFineCells.data()};
}

void BlockWindow::MoveTo(const NodeKey& low, const NodeKey& high) {
  low_ = low;
  size_ = {high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1};
  leaves_.clear();
  finest_ = BlockKind::kUniform;
  one_value_ = true;
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const Leaf leaf = LeafOf({x, y, z});
        const BlockKind kind = leaf.cell_of == kFineCells.data()     ? BlockKind::kFine
                               : leaf.cell_of == kCoarseCells.data() ? BlockKind::kCoarse
                                                                     : BlockKind::kUniform;
        finest_ = std::max(finest_, kind);
        if (leaves_.empty()) value_ = *leaf.values;
        one_value_ = one_value_ && kind == BlockKind::kUniform && *leaf.values == value_;
        leaves_.push_back(leaf);
      }
    }
  }
}

}  // namespace atlas::mapping
