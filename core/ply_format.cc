#include "core/ply_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>

#include "core/errors.h"
#include "core/text_lines.h"

namespace atlas::core {
namespace {

using Words = std::vector<std::string_view>;

PlyScalar ScalarFromName(std::string_view name) {
  static const std::map<std::string_view, PlyScalar> kNames = {
      {"char", PlyScalar::kInt8},     {"int8", PlyScalar::kInt8},     {"uchar", PlyScalar::kUint8},
      {"uint8", PlyScalar::kUint8},   {"short", PlyScalar::kInt16},   {"int16", PlyScalar::kInt16},
      {"ushort", PlyScalar::kUint16}, {"uint16", PlyScalar::kUint16}, {"int", PlyScalar::kInt32},
      {"int32", PlyScalar::kInt32},   {"uint", PlyScalar::kUint32},   {"uint32", PlyScalar::kUint32},
      {"float", PlyScalar::kFloat},   {"float32", PlyScalar::kFloat}, {"double", PlyScalar::kDouble},
      {"float64", PlyScalar::kDouble}};
  const auto found = kNames.find(name);
  if (found == kNames.end())
    throw InputError(fmt::format("PLY header: unknown type '{}'", name.substr(0, 40)));
  return found->second;
}

size_t SizeOf(PlyScalar type) {
  switch (type) {
    case PlyScalar::kInt8:
    case PlyScalar::kUint8:
      return 1;
    case PlyScalar::kInt16:
    case PlyScalar::kUint16:
      return 2;
    case PlyScalar::kDouble:
      return 8;
    default:
      return 4;
  }
}

/// "property float x" or "property list uchar int vertex_indices".
PlyProperty ReadProperty(const Words& words) {
  PlyProperty property;
  property.is_list = words.size() > 1 && words[1] == "list";
  if (words.size() < (property.is_list ? 5u : 3u)) throw InputError("PLY header: a property row ends early");
  if (property.is_list) property.count_type = ScalarFromName(words[2]);
  property.type = ScalarFromName(words[property.is_list ? 3 : 1]);
  property.name = words[property.is_list ? 4 : 2];
  return property;
}

PlyElement ReadElement(const Words& words) {
  const auto count = words.size() == 3 ? ParseNumber<size_t>(words[2]) : std::nullopt;
  if (!count) throw InputError("PLY header: bad element");
  return {std::string(words[1]), *count, {}};
}

PlyFormat ReadFormat(const Words& words) {
  const std::string_view format = words.size() > 1 ? words[1] : "",
                         version = words.size() > 2 ? words[2] : "";
  if (version != "1.0")
    throw InputError(fmt::format("PLY header: version '{}' (1.0 is read here)", version.substr(0, 40)));
  if (format == "ascii") return PlyFormat::kAscii;
  if (format == "binary_little_endian") return PlyFormat::kLittleEndian;
  if (format == "binary_big_endian") return PlyFormat::kBigEndian;
  throw InputError(fmt::format("PLY header: unknown format '{}'", format.substr(0, 40)));
}

}  // namespace

PlyHeader ReadPlyHeader(std::string_view bytes) {
  TextLines lines(bytes);
  if (SplitWords(lines.Next().value_or("")) != Words{"ply"}) throw InputError("not a PLY file");
  PlyHeader header;
  bool has_format = false;
  while (const auto line = lines.Next()) {
    const Words words = SplitWords(*line);
    if (words.empty()) continue;
    if (words[0] == "format") {
      header.format = ReadFormat(words);
      has_format = true;
    } else if (words[0] == "element") {
      header.elements.push_back(ReadElement(words));
    } else if (words[0] == "property") {
      if (header.elements.empty()) throw InputError("PLY header: property before any element");
      header.elements.back().properties.push_back(ReadProperty(words));
    } else if (words[0] == "end_header") {
      if (!has_format) throw InputError("PLY header: no format");
      header.size_bytes = lines.position();
      return header;
    }
  }
  throw InputError("the PLY header ends early");
}

void PlyValues::Skip(const PlyElement& element) {
  for (const PlyProperty& property : element.properties) {
    const double count = property.is_list ? Next(property.count_type) : 1.0;
    for (double k = 0; k < count; ++k) Next(property.type);
  }
}

size_t PlyValues::Capacity(const PlyElement& element) const {
  size_t record = 0;
  for (const PlyProperty& property : element.properties) {
    const size_t bytes = SizeOf(property.is_list ? property.count_type : property.type);
    record += format_ == PlyFormat::kAscii ? 2 : bytes;
  }
  return record == 0 ? 0 : (data_.size() - at_ + 1) / record;
}

double PlyValues::NextWord() {
  while (at_ < data_.size() && std::isspace(static_cast<unsigned char>(data_[at_]))) ++at_;
  if (at_ >= data_.size()) throw InputError("the PLY data end early");
  double value = 0.0;
  const char* first = data_.data() + at_ + (data_[at_] == '+' ? 1 : 0);
  const auto [last, error] = std::from_chars(first, data_.data() + data_.size(), value);
  if (error == std::errc::invalid_argument)
    throw InputError("the PLY data hold something other than a number");
  at_ = static_cast<size_t>(last - data_.data());
  return value;
}

template <typename T>
double PlyValues::NextAs() {
  if (data_.size() - at_ < sizeof(T)) throw InputError("the PLY data end early");
  char raw[sizeof(T)];
  std::memcpy(raw, data_.data() + at_, sizeof(T));
  constexpr bool kNativeBig = std::endian::native == std::endian::big;
  if ((format_ == PlyFormat::kBigEndian) != kNativeBig) std::reverse(raw, raw + sizeof(T));
  at_ += sizeof(T);
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return static_cast<double>(value);
}

double PlyValues::NextBinary(PlyScalar type) {
  switch (type) {
    case PlyScalar::kInt8:
      return NextAs<int8_t>();
    case PlyScalar::kUint8:
      return NextAs<uint8_t>();
    case PlyScalar::kInt16:
      return NextAs<int16_t>();
    case PlyScalar::kUint16:
      return NextAs<uint16_t>();
    case PlyScalar::kInt32:
      return NextAs<int32_t>();
    case PlyScalar::kUint32:
      return NextAs<uint32_t>();
    case PlyScalar::kFloat:
      return NextAs<float>();
    case PlyScalar::kDouble:
      return NextAs<double>();
  }
  return 0.0;
}

}  // namespace atlas::core
