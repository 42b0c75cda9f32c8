#include "mapping/io/scan_graph.h"

#include <fmt/format.h>

#include "core/byte_reader.h"
#include "core/text_lines.h"
#include "mapping/io/cloud_channels.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using core::Vec3f;

/// Vectors stand in the file as their length (int32), then so many doubles.
constexpr size_t kPointBytes = 4 + 3 * 8;
constexpr size_t kPoseBytes = kPointBytes + 4 + 4 * 8;
constexpr size_t kLeastNodeBytes = 4 + kPoseBytes + 4;
constexpr size_t kEdgeBytes = 4 + 4 + kPoseBytes + 8;
constexpr double kFarthestNode_m = 1e7;

Vec3 ReadVector(core::ByteReader* reader) {
  if (const auto length = reader->Next<int32_t>(); length != 3)
    reader->Fail(fmt::format("a vector of {} numbers (3) before byte {}", length, reader->position()));
  const double x = reader->Next<double>(), y = reader->Next<double>(), z = reader->Next<double>();
  return {x, y, z};
}

Pose CheckedPose(const core::ByteReader& reader, const Vec3& t, const Eigen::Quaterniond& q) {
  if (!(t.norm() < kFarthestNode_m))
    reader.Fail(fmt::format("a scan at {:g} m from the origin (limit {:g})", t.norm(), kFarthestNode_m));
  if (!(std::abs(q.norm() - 1.0) < 0.01))
    reader.Fail(fmt::format("a pose whose quaternion has length {:g} (1 within 0.01)", q.norm()));
  return core::MakePose(q.normalized().toRotationMatrix(), t);
}

Pose ReadPose(core::ByteReader* reader) {
  const Vec3 t = ReadVector(reader);
  if (const auto length = reader->Next<int32_t>(); length != 4)
    reader->Fail(fmt::format("a quaternion of {} numbers (4) before byte {}", length, reader->position()));
  const double w = reader->Next<double>(), x = reader->Next<double>(), y = reader->Next<double>(),
               z = reader->Next<double>();
  return CheckedPose(*reader, t, Eigen::Quaterniond(w, x, y, z));
}

ScanGraphIndex IndexBinary(std::string_view bytes, const std::string& file) {
  core::ByteReader reader(bytes, file);
  ScanGraphIndex index;
  const auto nodes = reader.Next<uint32_t>();
  reader.Require(nodes, kLeastNodeBytes, "scans");
  for (uint32_t i = 0; i < nodes; ++i) {
    ScanGraphIndex::Node node;
    node.points = reader.Next<uint32_t>();
    reader.Require(node.points, kPointBytes, "points");
    node.first_byte = reader.position();
    node.bytes = node.points * kPointBytes;
    reader.Take(node.bytes);
    node.T_map_lidar = ReadPose(&reader);
    reader.Next<uint32_t>();  // the node's name
    index.nodes.push_back(node);
  }
  const auto edges = reader.Next<uint32_t>();
  reader.Require(edges, kEdgeBytes, "edges");
  reader.Take(edges * kEdgeBytes);
  if (reader.remaining() != 0) reader.Fail(fmt::format("{} bytes are left over", reader.remaining()));
  return index;
}

/// `count` numbers after the first `skip` words of a row.
std::vector<double> NumbersOf(std::string_view line, size_t skip, size_t count, const std::string& file,
                              size_t number) {
  const auto words = core::SplitWords(line);
  std::vector<double> values;
  for (size_t k = skip; k < words.size(); ++k) {
    const auto value = core::ParseNumber<double>(words[k]);
    if (!value || !std::isfinite(*value))
      throw core::InputError(
          fmt::format("{}:{}: '{}' is no finite number", file, number, words[k].substr(0, 40)));
    values.push_back(*value);
  }
  if (values.size() != count)
    throw core::InputError(fmt::format("{}:{}: {} numbers ({})", file, number, values.size(), count));
  return values;
}

bool IsComment(std::string_view line) {
  return core::SplitWords(line).empty() || line.starts_with('#');
}

ScanGraphIndex IndexText(std::string_view text, const std::string& file) {
  const core::ByteReader reader(text, file);
  core::TextLines lines(text);
  ScanGraphIndex index;
  index.binary = false;
  while (const auto line = lines.Next()) {
    if (IsComment(*line)) continue;
    if (line->starts_with("NODE")) {
      const auto v = NumbersOf(*line, 1, 6, file, lines.number());
      const core::Mat3 R = core::RotationFromYawPitchRoll(v[5], v[4], v[3]);
      index.nodes.push_back(
          {CheckedPose(reader, Vec3(v[0], v[1], v[2]), Eigen::Quaterniond(R)), 0, lines.position(), 0});
    } else {
      if (index.nodes.empty()) reader.Fail("a point before the first NODE row");
      NumbersOf(*line, 0, 3, file, lines.number());
      ++index.nodes.back().points;
      index.nodes.back().bytes = lines.position() - index.nodes.back().first_byte;
    }
  }
  return index;
}

}  // namespace

ScanGraphIndex IndexScanGraph(std::string_view bytes, const std::string& file) {
  const bool text = bytes.starts_with("NODE") || bytes.starts_with("#");
  ScanGraphIndex index = text ? IndexText(bytes, file) : IndexBinary(bytes, file);
  if (index.nodes.empty()) throw core::InputError(fmt::format("{}: holds no scans", file));
  return index;
}

RecordedCloud ReadScanOfGraph(std::string_view bytes, const ScanGraphIndex& index, size_t node,
                              const std::string& file) {
  const ScanGraphIndex::Node& entry = index.nodes[node];
  core::ByteReader reader(bytes, file);
  reader.Take(entry.first_byte);
  const std::string_view data = reader.Take(entry.bytes);
  RawCloud raw;
  raw.p.reserve(entry.points);
  const auto add = [&](const Vec3& p) { raw.p.emplace_back(ToFloat(p.x()), ToFloat(p.y()), ToFloat(p.z())); };
  if (index.binary) {
    core::ByteReader points(data, file);
    for (size_t i = 0; i < entry.points; ++i) add(ReadVector(&points));
  } else {
    core::TextLines lines(data);
    while (const auto line = lines.Next()) {
      if (IsComment(*line)) continue;
      const auto v = NumbersOf(*line, 0, 3, file, lines.number());
      add(Vec3(v[0], v[1], v[2]));
    }
  }
  const auto points = static_cast<int>(raw.p.size());
  RecordedCloud cloud = FinishCloud(std::move(raw), 1, points, false, fmt::format("{}: scan {}", file, node));
  cloud.T_map_lidar = entry.T_map_lidar;
  return cloud;
}

}  // namespace atlas::mapping
