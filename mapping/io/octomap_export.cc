// OctoMap's files (Hornung et al. 2013), written node by node from our octree in Morton order, which is
// theirs too: no second tree is built.
//
// .bt: an inner node is two bytes, two bits a child (0 unknown, 1 free leaf, 2 occupied leaf, 3 inner), then
// its inner children. .ot: a node is its log-odds (float32) and a bit a child, then its children.

#include <fmt/format.h>

#include <algorithm>

#include "core/errors.h"
#include "core/files.h"
#include "mapping/io/map_file.h"

namespace atlas::mapping {
namespace {

constexpr int kChunkDepth = 10;  // of OctoMap's 16 levels
constexpr int kHalfChunks = 1 << (kChunkDepth - 1);
constexpr size_t kBufferBytes = size_t{1} << 22;

/// What a parent must know of a node.
struct Summary {
  enum class State : uint8_t { kUnknown, kLeaf, kInner } state = State::kUnknown;
  float log_odds = 0.0f;  ///< of a leaf, or the greatest below
  uint64_t nodes = 0;     ///< from here down
};

float LogOddsOf(OccupancyField::Value v) {
  return static_cast<float>(OccupancyField::LogOdds(v));
}
float LogOddsOf(TsdfField::Value v) {
  const int sign = TsdfField::Occupied(v) ? OccupancyField::kMax : OccupancyField::kMin;
  return LogOddsOf(static_cast<OccupancyField::Value>(sign));
}

class NodeEncoder {
 public:
  NodeEncoder(bool binary, std::string* out) : binary_(binary), out_(out) {}

  Summary Leaf(float log_odds) {
    if (binary_) {
      log_odds = log_odds > 0.0f ? 1.0f : -1.0f;
    } else {
      AppendNode(log_odds, 0);
    }
    return {Summary::State::kLeaf, log_odds, 1};
  }

  /// A node of eight; `child(i)` encodes the i-th and returns its summary. One that holds one value is a
  /// leaf.
  template <typename Child>
  Summary Join(const Child& child) {
    const size_t at = out_->size();
    out_->resize(at + HeadBytes());
    std::array<Summary, 8> children;
    for (int i = 0; i < 8; ++i) children[static_cast<size_t>(i)] = child(i);
    const Summary joined = Merge(children);
    if (joined.state == Summary::State::kInner) {
      WriteHead(joined, children, at);
    } else {
      out_->resize(at);
      if (joined.state == Summary::State::kLeaf && !binary_) AppendNode(joined.log_odds, 0);
    }
    return joined;
  }

  static Summary Merge(const std::array<Summary, 8>& children) {
    using State = Summary::State;
    Summary joined{State::kUnknown, -1e9f, 1};
    bool same = true;
    for (const Summary& child : children) {
      same = same && child.state == State::kLeaf && child.log_odds == children[0].log_odds;
      if (child.state == State::kUnknown) continue;
      joined.state = State::kInner;
      joined.log_odds = std::max(joined.log_odds, child.log_odds);
      joined.nodes += child.nodes;
    }
    if (joined.state == State::kUnknown) return {};
    return same ? Summary{State::kLeaf, joined.log_odds, 1} : joined;
  }

  void AppendHead(const Summary& node, const std::array<Summary, 8>& children) {
    const size_t at = out_->size();
    out_->resize(at + HeadBytes());
    WriteHead(node, children, at);
  }
  void AppendNode(float log_odds, uint8_t child_bits) {
    out_->append(reinterpret_cast<const char*>(&log_odds), 4);
    out_->push_back(static_cast<char>(child_bits));
  }

 private:
  size_t HeadBytes() const { return binary_ ? 2 : 5; }

  void WriteHead(const Summary& node, const std::array<Summary, 8>& children, size_t at) {
    char* head = out_->data() + at;
    if (!binary_) {
      uint8_t bits = 0;
      for (size_t i = 0; i < 8; ++i) {
        if (children[i].state != Summary::State::kUnknown) bits = static_cast<uint8_t>(bits | 1u << i);
      }
      std::memcpy(head, &node.log_odds, 4);
      head[4] = static_cast<char>(bits);
      return;
    }
    uint16_t bits = 0;
    for (size_t i = 0; i < 8; ++i) {
      const unsigned code = children[i].state == Summary::State::kUnknown ? 0u
                            : children[i].state == Summary::State::kInner ? 3u
                            : children[i].log_odds > 0.0f                 ? 2u
                                                                          : 1u;
      bits = static_cast<uint16_t>(bits | code << (2 * i));
    }
    std::memcpy(head, &bits, 2);
  }

  bool binary_;
  std::string* out_;
};

template <typename Field>
class ChunkEncoder {
 public:
  using Chunk = typename Octree<Field>::Chunk;
  ChunkEncoder(const Octree<Field>& map, NodeEncoder* nodes) : map_(map), nodes_(nodes) {}

  Summary Encode(const Chunk& chunk) {
    return nodes_->Join([&](int i) {
      return nodes_->Join(
          [&](int j) { return nodes_->Join([&](int k) { return EncodeBlock(chunk, 64 * i + 8 * j + k); }); });
    });
  }

 private:
  Summary EncodeValue(typename Field::Value value) {
    return Field::Known(value) ? nodes_->Leaf(LogOddsOf(value)) : Summary{};
  }

  Summary EncodeBlock(const Chunk& chunk, int block) {
    switch (chunk.Kind(block)) {
      case BlockKind::kUniform:
        return EncodeValue(chunk.uniform.Get(block));
      case BlockKind::kCoarse:
        return EncodeCells(
            [&](int cell, const NodeKey&) { return EncodeValue(map_.Coarse(chunk, block).Get(cell)); });
      case BlockKind::kFine:
        return EncodeCells([&](int, const NodeKey& at) {
          const auto& leaf = map_.Fine(chunk, block);
          return nodes_->Join([&](int i) {
            return EncodeValue(leaf.Get(VoxelIndex(at.x + (i & 1), at.y + (i >> 1 & 1), at.z + (i >> 2))));
          });
        });
    }
    return {};
  }

  /// `encode(cell, corner)` on the 2 x 2 x 2 cells of a block, in Morton order.
  template <typename Cell>
  Summary EncodeCells(const Cell& encode) {
    return nodes_->Join([&](int i) {
      return nodes_->Join([&](int j) {
        const NodeKey at{4 * (i & 1) + 2 * (j & 1), 4 * (i >> 1 & 1) + 2 * (j >> 1 & 1),
                         4 * (i >> 2) + 2 * (j >> 2)};
        return encode(CellOfVoxel(VoxelIndex(at.x, at.y, at.z)), at);
      });
    });
  }

  const Octree<Field>& map_;
  NodeEncoder* nodes_;
};

/// The nodes above the chunks, and the order in which all is written.
template <typename Field>
class Exporter {
 public:
  Exporter(const Octree<Field>& map, bool binary)
      : map_(map), binary_(binary), nodes_(binary, &out_), encoder_(map, &nodes_) {}

  void Write(const std::filesystem::path& path) {
    Summarise(path);
    const Summary root = SummaryOf(0, chunks_.size(), 0);
    if (root.state == Summary::State::kUnknown) {
      throw core::InputError(
          fmt::format("{}: the map holds nothing known, so there is nothing to export", path.string()));
    }
    core::AtomicFile file(path);
    file.Write(
        fmt::format("# Octomap OcTree {}file\n# (feel free to add / change comments, but leave the "
                    "first line as it is!)\n#\nid OcTree\nsize {}\nres {}\ndata\n",
                    binary_ ? "binary " : "", root.nodes, map_.resolution_m()));
    WriteNode(0, chunks_.size(), 0, &file);
    file.Write(out_);
    file.Commit();
  }

 private:
  struct Entry {
    uint64_t code;
    const typename Octree<Field>::Chunk* chunk;
    Summary summary;
  };

  /// First pass: what each chunk comes to, which its parents' bytes and the file's header must tell.
  void Summarise(const std::filesystem::path& path) {
    for (const auto* chunk : map_.Chunks()) {
      const Summary summary = encoder_.Encode(*chunk);
      out_.clear();
      if (summary.state == Summary::State::kUnknown) continue;
      for (const int32_t k : {chunk->key.x, chunk->key.y, chunk->key.z}) {
        if (k >= -kHalfChunks && k < kHalfChunks) continue;
        throw core::InputError(fmt::format("{}: voxel at {:.1f} m, OctoMap reaches {:.1f} m at {} m a voxel",
                                           path.string(), k * kChunkSide * map_.resolution_m(),
                                           kHalfChunks * kChunkSide * map_.resolution_m(),
                                           map_.resolution_m()));
      }
      const auto coordinate = [](int32_t k) { return static_cast<uint32_t>(k + kHalfChunks); };
      chunks_.push_back(
          {MortonCode(coordinate(chunk->key.x), coordinate(chunk->key.y), coordinate(chunk->key.z)), chunk,
           summary});
    }
    std::sort(chunks_.begin(), chunks_.end(), [](const Entry& a, const Entry& b) { return a.code < b.code; });
  }

  /// Where the eight children of the node at `depth` over the chunks [begin, end) begin.
  std::array<size_t, 9> Split(size_t begin, size_t end, int depth) const {
    const int shift = 3 * (kChunkDepth - 1 - depth);
    std::array<size_t, 9> bounds;
    bounds[0] = begin;
    for (uint64_t i = 0; i < 8; ++i) {
      size_t& to = bounds[i + 1] = bounds[i];
      while (to < end && (chunks_[to].code >> shift & 7) == i) ++to;
    }
    return bounds;
  }

  Summary SummaryOf(size_t begin, size_t end, int depth) const {
    if (begin == end) return {};
    if (depth == kChunkDepth) return chunks_[begin].summary;
    return NodeEncoder::Merge(ChildrenOf(Split(begin, end, depth), depth));
  }
  std::array<Summary, 8> ChildrenOf(const std::array<size_t, 9>& bounds, int depth) const {
    std::array<Summary, 8> children;
    for (size_t i = 0; i < 8; ++i) children[i] = SummaryOf(bounds[i], bounds[i + 1], depth + 1);
    return children;
  }

  void WriteNode(size_t begin, size_t end, int depth, core::AtomicFile* file) {
    if (begin == end) return;
    if (depth == kChunkDepth) {
      encoder_.Encode(*chunks_[begin].chunk);
    } else {
      const auto bounds = Split(begin, end, depth);
      const auto children = ChildrenOf(bounds, depth);
      const Summary node = NodeEncoder::Merge(children);
      if (node.state == Summary::State::kLeaf) {
        if (!binary_) nodes_.AppendNode(node.log_odds, 0);
      } else {
        nodes_.AppendHead(node, children);
        for (size_t i = 0; i < 8; ++i) WriteNode(bounds[i], bounds[i + 1], depth + 1, file);
      }
    }
    if (out_.size() < kBufferBytes) return;
    file->Write(out_);
    out_.clear();
  }

  const Octree<Field>& map_;
  bool binary_;
  std::string out_;
  NodeEncoder nodes_;
  ChunkEncoder<Field> encoder_;
  std::vector<Entry> chunks_;
};

}  // namespace

template <typename Field>
void ExportOctomap(const std::filesystem::path& path, const Octree<Field>& map) {
  const std::string extension = path.extension();
  if (extension != ".bt" && extension != ".ot") {
    throw core::InputError(fmt::format("{}: extension '{}', must be .bt or .ot", path.string(), extension));
  }
  Exporter<Field>(map, extension == ".bt").Write(path);
}

template void ExportOctomap(const std::filesystem::path&, const OccupancyOctree&);
template void ExportOctomap(const std::filesystem::path&, const TsdfOctree&);

}  // namespace atlas::mapping
