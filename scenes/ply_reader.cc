#include "scenes/ply_reader.h"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <map>
#include <sstream>
#include <string>

#include "core/errors.h"

namespace atlas::scenes {
namespace {

using core::InputError;

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat;
  bool is_list = false;
  Scalar count_type = Scalar::kUint8;
};

struct Element {
  std::string name;
  size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  std::string format;
  std::vector<Element> elements;
  size_t size_bytes = 0;
};

Scalar ScalarFromName(const std::string& name) {
  static const std::map<std::string, Scalar> kNames = {
      {"char", Scalar::kInt8},     {"int8", Scalar::kInt8},     {"uchar", Scalar::kUint8},
      {"uint8", Scalar::kUint8},   {"short", Scalar::kInt16},   {"int16", Scalar::kInt16},
      {"ushort", Scalar::kUint16}, {"uint16", Scalar::kUint16}, {"int", Scalar::kInt32},
      {"int32", Scalar::kInt32},   {"uint", Scalar::kUint32},   {"uint32", Scalar::kUint32},
      {"float", Scalar::kFloat},   {"float32", Scalar::kFloat}, {"double", Scalar::kDouble},
      {"float64", Scalar::kDouble}};
  const auto found = kNames.find(name);
  if (found == kNames.end()) throw InputError(fmt::format("PLY header: unknown type '{}'", name));
  return found->second;
}

Property ReadProperty(std::istringstream& words) {
  Property property;
  std::string type, count_type;
  words >> type;
  if (type == "list") {
    property.is_list = true;
    words >> count_type >> type;
    property.count_type = ScalarFromName(count_type);
  }
  property.type = ScalarFromName(type);
  words >> property.name;
  return property;
}

Header ReadHeader(std::string_view bytes) {
  if (bytes.substr(0, 3) != "ply") throw InputError("not a PLY file");
  Header header;
  size_t at = 0;
  while (at < bytes.size()) {
    const size_t end = std::min(bytes.find('\n', at), bytes.size());
    std::istringstream words{std::string(bytes.substr(at, end - at))};
    at = end + 1;
    std::string word;
    words >> word;
    if (word == "format") words >> header.format;
    if (word == "element") {
      Element element;
      if (!(words >> element.name >> element.count)) throw InputError("PLY header: bad element");
      header.elements.push_back(element);
    }
    if (word == "property") {
      if (header.elements.empty()) throw InputError("PLY header: property before any element");
      header.elements.back().properties.push_back(ReadProperty(words));
    }
    if (word == "end_header") {
      header.size_bytes = std::min(at, bytes.size());
      if (header.format == "ascii" || header.format.starts_with("binary_")) return header;
      throw InputError(fmt::format("PLY header: unknown format '{}'", header.format));
    }
  }
  throw InputError("the PLY header ends early");
}

/// The numbers after the header, one by one.
class Values {
 public:
  Values(std::string_view data, const std::string& format) : data_(data), format_(format) {}

  double Next(Scalar type) { return format_ == "ascii" ? NextWord() : NextBinary(type); }

 private:
  [[noreturn]] static void FailShort() { throw InputError("the PLY data end early"); }

  double NextWord() {
    while (at_ < data_.size() && std::isspace(static_cast<unsigned char>(data_[at_]))) ++at_;
    if (at_ >= data_.size()) FailShort();
    double value = 0.0;
    const char* first = data_.data() + at_ + (data_[at_] == '+' ? 1 : 0);
    const auto [last, error] = std::from_chars(first, data_.data() + data_.size(), value);
    if (error == std::errc::invalid_argument)
      throw InputError("the PLY data hold something other than a number");
    at_ = static_cast<size_t>(last - data_.data());
    return value;
  }

  template <typename T>
  double NextAs() {
    if (data_.size() - at_ < sizeof(T)) FailShort();
    char raw[sizeof(T)];
    std::memcpy(raw, data_.data() + at_, sizeof(T));
    if (format_ == "binary_big_endian") std::reverse(raw, raw + sizeof(T));
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return static_cast<double>(value);
  }

  double NextBinary(Scalar type) {
    switch (type) {
      case Scalar::kInt8:
        return NextAs<int8_t>();
      case Scalar::kUint8:
        return NextAs<uint8_t>();
      case Scalar::kInt16:
        return NextAs<int16_t>();
      case Scalar::kUint16:
        return NextAs<uint16_t>();
      case Scalar::kInt32:
        return NextAs<int32_t>();
      case Scalar::kUint32:
        return NextAs<uint32_t>();
      case Scalar::kFloat:
        return NextAs<float>();
      case Scalar::kDouble:
        return NextAs<double>();
    }
    return 0.0;
  }

  std::string_view data_;
  std::string format_;
  size_t at_ = 0;
};

uint32_t CheckedIndex(double index, size_t vertices) {
  if (index >= 0.0 && index < static_cast<double>(vertices)) return static_cast<uint32_t>(index);
  throw InputError(fmt::format("a face names vertex {} of {}", index, vertices));
}

void ReadRecord(const Element& element, Values& values, core::TriMesh& mesh) {
  core::Vec3f p = core::Vec3f::Zero();
  for (const Property& property : element.properties) {
    if (!property.is_list) {
      const double value = values.Next(property.type);
      for (int k = 0; k < 3; ++k) {
        if (property.name == std::string(1, "xyz"[k])) p[k] = static_cast<float>(value);
      }
      continue;
    }
    const double count = values.Next(property.count_type);
    const bool is_face = element.name == "face" && property.name.starts_with("vertex_ind");
    std::array<uint32_t, 3> t = {0, 0, 0};
    for (double k = 0; k < count; ++k) {
      const double value = values.Next(property.type);
      if (!is_face) continue;
      const uint32_t index = CheckedIndex(value, mesh.vertices.size());
      t = k == 0 ? std::array{index, index, index} : std::array{t[0], t[2], index};
      if (k >= 2) mesh.triangles.push_back(t);
    }
  }
  if (element.name == "vertex") mesh.vertices.push_back(p);
}

}  // namespace

core::TriMesh ParsePly(std::string_view bytes) {
  const Header header = ReadHeader(bytes);
  Values values(bytes.substr(header.size_bytes), header.format);
  core::TriMesh mesh;
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;
    for (size_t k = 0; k < element.count; ++k) ReadRecord(element, values, mesh);
  }
  return mesh;
}

}  // namespace atlas::scenes
