// The PLY container: named elements with properties, ASCII or binary, whatever they mean.
//
//   const PlyHeader header = ReadPlyHeader(bytes);
//   PlyValues values(bytes, header);
//   for each element, each of its count records, each property: values.Next(property.type) ...
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace atlas::core {

enum class PlyScalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct PlyProperty {
  std::string name;
  PlyScalar type = PlyScalar::kFloat;
  bool is_list = false;  ///< a count of `count_type`, then so many values
  PlyScalar count_type = PlyScalar::kUint8;
};

struct PlyElement {
  std::string name;
  size_t count = 0;  ///< as the header says: may be more than the file holds
  std::vector<PlyProperty> properties;
};

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  size_t size_bytes = 0;
};

/// @throws InputError with the reason (the caller names the file): not PLY, an unknown version, format or
/// type, no end.
PlyHeader ReadPlyHeader(std::string_view bytes);

/// The numbers after the header, one by one.
class PlyValues {
 public:
  /// @pre bytes outlive this.
  PlyValues(std::string_view bytes, const PlyHeader& header)
      : data_(bytes.substr(header.size_bytes)), format_(header.format) {}

  /// @throws InputError when the data end, or hold something other than a number.
  double Next(PlyScalar type) { return format_ == PlyFormat::kAscii ? NextWord() : NextBinary(type); }
  /// Skips a whole record of an element.
  void Skip(const PlyElement& element);
  /// An upper bound of the records of `element` that the rest of the data can hold.
  size_t Capacity(const PlyElement& element) const;

 private:
  double NextWord();
  double NextBinary(PlyScalar type);
  template <typename T>
  double NextAs();

  std::string_view data_;
  PlyFormat format_;
  size_t at_ = 0;
};

}  // namespace atlas::core
