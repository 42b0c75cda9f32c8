// A 64-bit hash over bytes, fed piece by piece: tells contents apart, does not resist forgery.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

namespace atlas::core {

class Fingerprint {
 public:
  void Bytes(const void* data, size_t size);
  template <typename T>
  void Value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Bytes(&value, sizeof(value));
  }
  /// Its length counts, so that "ab", "c" differs from "a", "bc".
  void Text(std::string_view text);

  uint64_t value() const { return state_; }
  /// The value as 16 hexadecimal digits.
  std::string Hex() const;

 private:
  uint64_t state_ = 0x9e3779b97f4a7c15ull;
};

}  // namespace atlas::core
