// Numbers from the bytes of a file, never past their end.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/errors.h"

namespace atlas::core {

/// Walks over `bytes`, which outlive it. Every member throws InputError "FILE: ends early ..." rather than
/// read past the end.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  size_t position() const { return at_; }
  size_t remaining() const { return bytes_.size() - at_; }
  const std::string& file() const { return file_; }

  /// The next number, stored little endian. Big endian: `NextBig`.
  template <typename T>
  T Next() {
    return Read<T>(std::endian::native == std::endian::little);
  }
  template <typename T>
  T NextBig() {
    return Read<T>(std::endian::native == std::endian::big);
  }
  std::string_view Take(size_t count) {
    Require(count, 1, "data");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  /// Throws unless `count` things of `size_bytes` (> 0) are left: to be called before room is made for them.
  void Require(uint64_t count, size_t size_bytes, std::string_view what) const {
    if (count > remaining() / size_bytes) {
      Fail(fmt::format("ends early: {} x {} bytes of {} announced at byte {}, {} bytes left", count,
                       size_bytes, what, at_, remaining()));
    }
  }
  [[noreturn]] void Fail(std::string_view reason) const {
    throw InputError(fmt::format("{}: {}", file_, reason));
  }

 private:
  template <typename T>
  T Read(bool in_order) {
    static_assert(std::is_arithmetic_v<T>);
    if (remaining() < sizeof(T)) Require(1, sizeof(T), "a number");
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + at_, sizeof(T));
    if (!in_order) std::reverse(raw, raw + sizeof(T));
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  std::string_view bytes_;
  std::string file_;
  size_t at_ = 0;
};

}  // namespace atlas::core
