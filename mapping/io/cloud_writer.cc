#include "mapping/io/cloud_writer.h"

#include <fmt/format.h>

#include <cassert>
#include <cstring>

#include "core/files.h"
#include "mapping/io/lzf.h"

namespace atlas::mapping {
namespace {

using core::ReturnKind;
using core::Vec3f;

/// One field of all points, as it goes into a file.
struct FieldOut {
  std::string name;
  char type;  // F, U
  size_t size_bytes;
  std::string bytes;  // points * size_bytes

  template <typename T>
  void Put(T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
};

std::vector<FieldOut> FieldsOf(const RecordedCloud& cloud) {
  std::vector<FieldOut> fields;
  for (int k = 0; k < 3; ++k) {
    fields.push_back({std::string(1, "xyz"[k]), 'F', 4, {}});
    for (const Vec3f& p : cloud.p_lidar) fields.back().Put(p[k]);
  }
  if (!cloud.time_s.empty()) {
    fields.push_back({"t", 'F', 4, {}});
    for (const float t : cloud.time_s) fields.back().Put(t);
  }
  if (!cloud.kind.empty()) {
    fields.push_back({"kind", 'U', 1, {}});
    for (const ReturnKind kind : cloud.kind) fields.back().Put(static_cast<uint8_t>(kind));
  }
  if (!cloud.ring.empty()) {
    fields.push_back({"ring", 'U', 2, {}});
    for (const uint16_t ring : cloud.ring) fields.back().Put(ring);
  }
  return fields;
}

template <typename T>
T ValueAt(const FieldOut& field, size_t i) {
  T value;
  std::memcpy(&value, field.bytes.data() + i * sizeof(T), sizeof(T));
  return value;
}

std::string TextOf(const FieldOut& field, size_t i) {
  if (field.type == 'F') return fmt::format("{}", ValueAt<float>(field, i));
  return field.size_bytes == 1 ? fmt::format("{}", ValueAt<uint8_t>(field, i))
                               : fmt::format("{}", ValueAt<uint16_t>(field, i));
}

std::string AsText(const std::vector<FieldOut>& fields, size_t points) {
  std::string out;
  for (size_t i = 0; i < points; ++i) {
    for (const FieldOut& field : fields) {
      out.append(TextOf(field, i));
      out.push_back(&field == &fields.back() ? '\n' : ' ');
    }
  }
  return out;
}

std::string AsRecords(const std::vector<FieldOut>& fields, size_t points) {
  std::string out;
  for (size_t i = 0; i < points; ++i) {
    for (const FieldOut& field : fields) out.append(field.bytes, i * field.size_bytes, field.size_bytes);
  }
  return out;
}

std::string AsPackedColumns(const std::vector<FieldOut>& fields) {
  std::string columns;
  for (const FieldOut& field : fields) columns += field.bytes;
  const std::string packed = LzfPack(columns);
  const uint32_t sizes[2] = {static_cast<uint32_t>(packed.size()), static_cast<uint32_t>(columns.size())};
  return std::string(reinterpret_cast<const char*>(sizes), sizeof(sizes)) + packed;
}

std::string HeaderRow(const std::string& key, const std::vector<FieldOut>& fields,
                      std::string (*value)(const FieldOut&)) {
  std::string row = key;
  for (const FieldOut& field : fields) {
    row.push_back(' ');
    row.append(value(field));
  }
  row.push_back('\n');
  return row;
}

std::string PcdHeader(const RecordedCloud& cloud, const std::vector<FieldOut>& fields, const char* data) {
  std::string out = "# .PCD v0.7\nVERSION 0.7\n";
  out += HeaderRow("FIELDS", fields, [](const FieldOut& f) { return f.name; });
  out += HeaderRow("SIZE", fields, [](const FieldOut& f) { return std::to_string(f.size_bytes); });
  out += HeaderRow("TYPE", fields, [](const FieldOut& f) { return std::string(1, f.type); });
  out += HeaderRow("COUNT", fields, [](const FieldOut&) { return std::string("1"); });
  const Eigen::Quaterniond q(cloud.T_map_lidar.linear());
  const core::Vec3 t = cloud.T_map_lidar.translation();
  return out + fmt::format("WIDTH {}\nHEIGHT {}\nVIEWPOINT {} {} {} {} {} {} {}\nPOINTS {}\nDATA {}\n",
                           cloud.columns, cloud.rows, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z(),
                           cloud.size(), data);
}

}  // namespace

std::string CloudToPcd(const RecordedCloud& cloud, CloudEncoding encoding) {
  assert(cloud.size() == static_cast<size_t>(cloud.rows) * static_cast<size_t>(cloud.columns));
  const std::vector<FieldOut> fields = FieldsOf(cloud);
  switch (encoding) {
    case CloudEncoding::kAscii:
      return PcdHeader(cloud, fields, "ascii") + AsText(fields, cloud.size());
    case CloudEncoding::kBinary:
      return PcdHeader(cloud, fields, "binary") + AsRecords(fields, cloud.size());
    case CloudEncoding::kBinaryCompressed:
      break;
  }
  return PcdHeader(cloud, fields, "binary_compressed") + AsPackedColumns(fields);
}

std::string CloudToPly(const RecordedCloud& cloud, CloudEncoding encoding) {
  const std::vector<FieldOut> fields = FieldsOf(cloud);
  const bool text = encoding == CloudEncoding::kAscii;
  std::string out = fmt::format("ply\nformat {} 1.0\nelement vertex {}\n",
                                text ? "ascii" : "binary_little_endian", cloud.size());
  for (const FieldOut& field : fields) {
    const char* type = field.type == 'F' ? "float" : field.size_bytes == 1 ? "uchar" : "ushort";
    out += fmt::format("property {} {}\n", type, field.name);
  }
  return out + "end_header\n" + (text ? AsText(fields, cloud.size()) : AsRecords(fields, cloud.size()));
}

std::string ScanToPcd(const core::LidarScan& scan) {
  RecordedCloud cloud;
  cloud.organised = scan.organised();
  cloud.rows = std::max(scan.rows, 1);
  cloud.columns = scan.columns;
  for (size_t i = 0; i < scan.size(); ++i) {
    const bool hit = scan.kind[i] == ReturnKind::kHit;
    cloud.p_lidar.push_back(hit ? Vec3f(scan.range_m[i] * scan.direction_lidar[i])
                                : Vec3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  }
  cloud.time_s = scan.time_s;
  cloud.kind = scan.kind;
  return CloudToPcd(cloud, CloudEncoding::kBinary);
}

std::string ScanFileName(double stamp_s) {
  return fmt::format("{:.9f}.pcd", stamp_s);
}

void WriteScan(const std::filesystem::path& folder, const core::LidarScan& scan) {
  core::WriteFileAtomically(folder / "scans" / ScanFileName(scan.stamp_s), ScanToPcd(scan));
}

}  // namespace atlas::mapping
