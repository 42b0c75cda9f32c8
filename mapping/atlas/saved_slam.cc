#include "mapping/atlas/saved_slam.h"

#include <fmt/format.h>

#include <regex>
#include <utility>

#include "core/checked_folder.h"
#include "core/csv_table.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/mesh.h"
#include "mapping/io/recorded_cloud.h"
#include "mapping/slam/g2o_file.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using Plan = std::vector<PlaceDescriptor::Cell>;

constexpr const char* kNodesHead = "keyframe,voxel_m,";

bool IsSlamFile(const std::string& name) {
  static const std::regex kOfNode("(node_[0-9]{5,}\\.ply|view_[0-9]{5,}\\.pgm|plan_[0-9]{5,}\\.pbm)");
  return name == "graph.g2o" || name == "nodes.csv" || name == "files.csv" || std::regex_match(name, kOfNode);
}

std::string NodeFile(const char* kind, size_t node, const char* ending) {
  return fmt::format("{}_{:05d}.{}", kind, node, ending);
}

// Binary PGM (two bytes a value, the higher first) and PBM (a bit a cell, the highest first).

const std::string& ViewHead() {
  static const std::string kHead =
      fmt::format("P5\n{} {}\n65535\n", RangeView::kColumns, 2 * RangeView::kRows);
  return kHead;
}

std::string PgmOf(const NodeMemory& node) {
  std::string image = ViewHead();
  for (const std::vector<uint16_t>* half : {&node.nearest, &node.farthest}) {
    for (const uint16_t value : *half) {
      image.push_back(static_cast<char>(value >> 8));
      image.push_back(static_cast<char>(value & 0xff));
    }
  }
  return image;
}

void ReadPgm(const fs::path& file, NodeMemory* node) {
  const std::string image = core::ReadFile(file);
  const size_t head = ViewHead().size(), size = head + 4 * RangeView::kCells;
  if (image.size() != size || !image.starts_with(ViewHead())) {
    throw core::InputError(fmt::format("{}: no 16-bit PGM of {} x {}", file.string(), RangeView::kColumns,
                                       2 * RangeView::kRows));
  }
  const auto byte = [&](size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(image[i])); };
  for (size_t cell = 0; cell < 2 * RangeView::kCells; ++cell) {
    const auto value = static_cast<uint16_t>(byte(head + 2 * cell) << 8 | byte(head + 2 * cell + 1));
    (cell < RangeView::kCells ? node->nearest : node->farthest).push_back(value);
  }
}

constexpr int kSide = PlaceDescriptor::kSide;
constexpr size_t kRowBytes = kSide / 8;
static_assert(kSide % 8 == 0);

const std::string& PlanHead() {
  static const std::string kHead = fmt::format("P4\n{} {}\n", kSide, kSide);
  return kHead;
}

std::string PbmOf(const Plan& plan) {
  std::string image = PlanHead() + std::string(kRowBytes * kSide, '\0');
  for (const PlaceDescriptor::Cell& cell : plan) {
    char& byte =
        image[PlanHead().size() + static_cast<size_t>(cell.y) * kRowBytes + static_cast<size_t>(cell.x) / 8];
    byte = static_cast<char>(byte | 0x80 >> (cell.x % 8));
  }
  return image;
}

Plan ReadPbm(const fs::path& file) {
  const std::string image = core::ReadFile(file);
  const size_t head = PlanHead().size();
  if (image.size() != head + kRowBytes * kSide || !image.starts_with(PlanHead()))
    throw core::InputError(fmt::format("{}: no PBM of {} x {}", file.string(), kSide, kSide));
  Plan plan;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const char byte = image[head + static_cast<size_t>(y) * kRowBytes + static_cast<size_t>(x) / 8];
      if (byte & 0x80 >> (x % 8)) plan.push_back({static_cast<int16_t>(x), static_cast<int16_t>(y)});
    }
  }
  return plan;
}

}  // namespace

fs::path SlamFolderOf(const fs::path& atlas_folder) {
  return atlas_folder / "slam";
}

void WriteSlamMemory(const fs::path& folder, const SlamMemory& memory) {
  core::CheckedFolderWriter writer(folder);
  G2oGraph file;
  file.graph = memory.graph;
  for (uint32_t node = 0; node < memory.graph.size(); ++node) file.id.push_back(node);
  writer.Text("graph.g2o", FormatG2o(file));
  std::string nodes = std::string(kNodesHead) + core::kCsvPoseHead + "\n";
  for (size_t node = 0; node < memory.nodes.size(); ++node) {
    const NodeMemory& seen = memory.nodes[node];
    nodes += fmt::format("{},{},{}\n", node, seen.voxel_m, core::CsvOfPose(seen.T_node_lidar));
    const std::string cloud = NodeFile("node", node, "ply");
    core::WritePly(writer.At(cloud), core::PointCloud{seen.points_lidar});
    writer.Written(cloud);
    writer.Text(NodeFile("view", node, "pgm"), PgmOf(seen));
    writer.Text(NodeFile("plan", node, "pbm"), PbmOf(seen.plan));
  }
  writer.Text("nodes.csv", nodes);
  writer.Finish(IsSlamFile);
}

SlamMemory LoadSlamMemory(const fs::path& folder) {
  core::CheckFolder(folder, IsSlamFile);
  SlamMemory memory;
  memory.graph = ReadG2o(folder / "graph.g2o").graph;
  core::CsvTable table(folder / "nodes.csv", std::string(kNodesHead) + core::kCsvPoseHead);
  while (table.NextRow()) {
    const auto node = static_cast<uint32_t>(memory.nodes.size());
    table.Number<uint32_t>(node, node);
    NodeMemory seen;
    seen.voxel_m = table.Number<double>(1e-3, 10.0);
    seen.T_node_lidar = table.NextPose();
    const fs::path cloud = folder / NodeFile("node", node, "ply");
    seen.points_lidar = ReadCloud(cloud).p_lidar;
    ReadPgm(folder / NodeFile("view", node, "pgm"), &seen);
    seen.plan = ReadPbm(folder / NodeFile("plan", node, "pbm"));
    memory.nodes.push_back(std::move(seen));
  }
  if (memory.nodes.size() != memory.graph.size()) {
    table.Fail(fmt::format("{} keyframes, {} nodes in graph.g2o", memory.nodes.size(), memory.graph.size()));
  }
  return memory;
}

}  // namespace atlas::mapping
