// PCD 0.7: a header of text lines, then points as text, as packed records, or as compressed columns.
#include <fmt/format.h>

#include <fstream>

#include "core/byte_reader.h"
#include "core/text_lines.h"
#include "mapping/io/cloud_channels.h"
#include "mapping/io/lzf.h"
#include "mapping/io/scan_source.h"

namespace atlas::mapping {
namespace {

using core::InputError;

constexpr uint64_t kMostFields = 1024;
constexpr uint64_t kMostValuesOfField = 1u << 20;

struct Field {
  std::string name;
  uint64_t size_bytes = 4;
  char type = 'F';
  uint64_t count = 1;
  std::optional<Channel> channel;
  uint64_t bytes() const { return size_bytes * count; }
};

struct PcdLayout {
  std::vector<Field> fields;
  uint64_t width = 0, height = 1, points = 0;
  std::vector<double> viewpoint = {0, 0, 0, 1, 0, 0, 0};
  std::string data;
  size_t size_bytes = 0;
};

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& file) : lines_(bytes), file_(file) {}

  PcdLayout Parse() {
    bool has_points = false, has_width = false;
    while (header_.data.empty()) {
      const auto line = lines_.Next();
      if (!line) Fail("the PCD header ends before its DATA row");
      words_ = core::SplitWords(*line);
      if (words_.empty() || words_[0].starts_with('#')) continue;
      const std::string_view key = words_[0];
      has_points |= key == "POINTS";
      has_width |= key == "WIDTH";
      ParseRow(key);
    }
    header_.size_bytes = lines_.position();
    if (header_.fields.empty()) Fail("the PCD header has no FIELDS");
    if (!has_width) header_.width = header_.points;
    if (!has_points) header_.points = header_.width * header_.height;
    CheckPoints();
    return std::move(header_);
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", file_, reason));
  }

  void ParseRow(std::string_view key) {
    if (key == "VERSION") {
      const std::string_view version = words_.size() > 1 ? words_[1] : "";
      if (!version.ends_with(".7") && !version.ends_with(".6") && !version.ends_with(".5"))
        Fail(fmt::format("PCD VERSION is '{}' (0.7 is read here)", version));
    } else if (key == "FIELDS" || key == "COLUMNS") {
      if (words_.size() - 1 > kMostFields)
        Fail(fmt::format("{} FIELDS (limit {})", words_.size(), kMostFields));
      for (size_t k = 1; k < words_.size(); ++k) {
        header_.fields.push_back({std::string(words_[k]), 4, 'F', 1, ChannelOf(words_[k])});
      }
    } else if (key == "SIZE" || key == "TYPE" || key == "COUNT") {
      ParseFieldRow(key);
    } else if (key == "WIDTH") {
      header_.width = Count(1);
    } else if (key == "HEIGHT") {
      header_.height = Count(1);
    } else if (key == "POINTS") {
      header_.points = Count(1);
    } else if (key == "VIEWPOINT") {
      ParseViewpoint();
    } else if (key == "DATA") {
      header_.data = words_.size() > 1 ? std::string(words_[1]) : "none";
    } else {
      Fail(fmt::format("line {}: '{}' is no row of a PCD header", lines_.number(), key.substr(0, 40)));
    }
  }

  void ParseFieldRow(std::string_view key) {
    if (words_.size() - 1 != header_.fields.size())
      Fail(fmt::format("{} has {} entries for {} FIELDS", key, words_.size() - 1, header_.fields.size()));
    for (size_t k = 1; k < words_.size(); ++k) {
      Field& field = header_.fields[k - 1];
      if (key == "SIZE") {
        field.size_bytes = Count(k);
        if (field.size_bytes != 1 && field.size_bytes != 2 && field.size_bytes != 4 && field.size_bytes != 8)
          Fail(fmt::format("SIZE of field '{}' is {} (1, 2, 4 or 8)", field.name, field.size_bytes));
      } else if (key == "TYPE") {
        field.type = words_[k][0];
        if (words_[k] != "F" && words_[k] != "I" && words_[k] != "U")
          Fail(fmt::format("TYPE of field '{}' is '{}' (F, I or U)", field.name, words_[k].substr(0, 40)));
      } else {
        field.count = Count(k);
        if (field.count > kMostValuesOfField)
          Fail(fmt::format("COUNT of field '{}' is {} (limit {})", field.name, field.count,
                           kMostValuesOfField));
      }
    }
  }

  void ParseViewpoint() {
    if (words_.size() != 8) Fail(fmt::format("VIEWPOINT has {} numbers (7)", words_.size() - 1));
    for (size_t k = 1; k < 8; ++k) {
      const auto value = core::ParseNumber<double>(words_[k]);
      if (!value || !(std::abs(*value) < 1e9))
        Fail(fmt::format("VIEWPOINT: '{}' is no coordinate", words_[k].substr(0, 40)));
      header_.viewpoint[k - 1] = *value;
    }
  }

  uint64_t Count(size_t k) const {
    const auto value = k < words_.size() ? core::ParseNumber<uint64_t>(words_[k]) : std::nullopt;
    if (!value) Fail(fmt::format("line {}: {} is not a count", lines_.number(), words_[0]));
    return *value;
  }

  void CheckPoints() const {
    constexpr uint64_t kMost = 2147483647;
    if (header_.width > kMost || header_.height > kMost || header_.width * header_.height != header_.points ||
        header_.points > kMost) {
      Fail(fmt::format("POINTS is {}, WIDTH x HEIGHT is {} x {}", header_.points, header_.width,
                       header_.height));
    }
    for (const Field& field : header_.fields) {
      if (field.type == 'F' && field.size_bytes < 4)
        Fail(fmt::format("field '{}' is a float of {} bytes (4 or 8)", field.name, field.size_bytes));
      if (field.channel && field.count == 0) Fail(fmt::format("COUNT of field '{}' is 0", field.name));
    }
  }

  core::TextLines lines_;
  const std::string& file_;
  std::vector<std::string_view> words_;
  PcdLayout header_;
};

/// The first value of a field, at `reader`; 64-bit counts lose their lowest bits.
double Number(const Field& field, core::ByteReader& reader) {
  if (field.type == 'F') return field.size_bytes == 4 ? reader.Next<float>() : reader.Next<double>();
  const bool is_signed = field.type == 'I';
  switch (field.size_bytes) {
    case 1:
      return is_signed ? reader.Next<int8_t>() : reader.Next<uint8_t>();
    case 2:
      return is_signed ? reader.Next<int16_t>() : reader.Next<uint16_t>();
    case 4:
      return is_signed ? reader.Next<int32_t>() : reader.Next<uint32_t>();
    default:
      return is_signed ? static_cast<double>(reader.Next<int64_t>())
                       : static_cast<double>(reader.Next<uint64_t>());
  }
}

uint64_t RecordBytes(const PcdLayout& header) {
  uint64_t bytes = 0;
  for (const Field& field : header.fields) bytes += field.bytes();
  return bytes;
}

/// Where each value of a field stands: records one after another, or all values of a field together.
void ReadBinary(const PcdLayout& header, std::string_view data, const std::string& file, bool by_columns,
                RawCloud* raw) {
  const uint64_t record = RecordBytes(header);
  uint64_t before = 0;
  for (const Field& field : header.fields) {
    const uint64_t first = by_columns ? before * header.points : before;
    const uint64_t step = by_columns ? field.bytes() : record;
    for (uint64_t i = 0; field.channel && i < header.points; ++i) {
      core::ByteReader reader(data.substr(first + i * step), file);
      raw->Set(*field.channel, i, Number(field, reader));
    }
    before += field.bytes();
  }
}

void ReadAscii(const PcdLayout& header, std::string_view data, const std::string& file, RawCloud* raw) {
  core::TextLines lines(data);
  for (uint64_t i = 0; i < header.points;) {
    const auto line = lines.Next();
    if (!line) throw InputError(fmt::format("{}: ends early: {} of {} points", file, i, header.points));
    const auto words = core::SplitWords(*line);
    if (words.empty()) continue;
    size_t k = 0;
    for (const Field& field : header.fields) {
      if (field.channel) {
        const auto value = k < words.size() ? core::ParseNumber<double>(words[k]) : std::nullopt;
        if (!value)
          throw InputError(fmt::format("{}: point {}: field '{}' is no number", file, i, field.name));
        raw->Set(*field.channel, i, *value);
      }
      k += field.count;
    }
    if (words.size() != k)
      throw InputError(
          fmt::format("{}: point {}: {} values (the header tells {})", file, i, words.size(), k));
    ++i;
  }
}

void ReadPoints(const PcdLayout& header, std::string_view bytes, const std::string& file, RawCloud* raw) {
  bool has[kChannels] = {};
  for (const Field& field : header.fields) {
    if (!field.channel) continue;
    if (has[*field.channel])
      throw InputError(fmt::format("{}: two FIELDS for what '{}' holds", file, field.name));
    has[*field.channel] = true;
    if (*field.channel == kTime) raw->time_is_single = field.type == 'F' && field.size_bytes == 4;
  }
  if (!has[kX] || !has[kY] || !has[kZ]) throw InputError(fmt::format("{}: FIELDS lack x, y or z", file));
  core::ByteReader reader(bytes, file);
  reader.Take(header.size_bytes);
  const uint64_t record = RecordBytes(header);
  if (header.data == "ascii") {
    reader.Require(header.points, 2 * header.fields.size() - 1, "points");
    raw->Resize(header.points, has);
    ReadAscii(header, reader.Take(reader.remaining()), file, raw);
  } else if (header.data == "binary") {
    reader.Require(header.points, record, "points");
    raw->Resize(header.points, has);
    ReadBinary(header, reader.Take(header.points * record), file, false, raw);
  } else if (header.data == "binary_compressed") {
    if (header.points == 0) return;
    const auto packed_bytes = reader.Next<uint32_t>(), bytes_unpacked = reader.Next<uint32_t>();
    if (bytes_unpacked / record != header.points || bytes_unpacked % record != 0)
      reader.Fail(
          fmt::format("{} bytes unpacked for {} points of {} bytes", bytes_unpacked, header.points, record));
    const auto data = LzfUnpack(reader.Take(packed_bytes), bytes_unpacked);
    if (!data) reader.Fail("the compressed data are damaged");
    raw->Resize(header.points, has);
    ReadBinary(header, *data, file, true, raw);
  } else {
    throw InputError(fmt::format("{}: DATA is '{}' (ascii, binary or binary_compressed)", file,
                                 header.data.substr(0, 40)));
  }
}

core::Pose Viewpoint(const PcdLayout& header, const std::string& file) {
  const auto& v = header.viewpoint;
  const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1.0) > 0.01)
    throw InputError(fmt::format("{}: VIEWPOINT: length of the quaternion is {:g} (1)", file, q.norm()));
  return core::MakePose(q.normalized().toRotationMatrix(), core::Vec3(v[0], v[1], v[2]));
}

}  // namespace

RecordedCloud ParsePcd(std::string_view bytes, const std::string& file) {
  const PcdLayout header = HeaderParser(bytes, file).Parse();
  RawCloud raw;
  ReadPoints(header, bytes, file, &raw);
  const bool organised = header.height > 1;
  RecordedCloud cloud =
      FinishCloud(std::move(raw), organised ? static_cast<int>(header.height) : 1,
                  static_cast<int>(organised ? header.width : header.points), organised, file);
  cloud.T_map_lidar = Viewpoint(header, file);
  return cloud;
}

core::Pose ViewpointOf(const std::filesystem::path& path) {
  constexpr size_t kMostHeaderBytes = 8192;
  core::CheckReadable(path);
  std::ifstream in(path, std::ios::binary);
  std::string head(kMostHeaderBytes, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(in.gcount()));
  return Viewpoint(HeaderParser(head, path.string()).Parse(), path.string());
}

}  // namespace atlas::mapping
