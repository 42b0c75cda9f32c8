// CRC-64 of file contents: finds every flipped bit and every burst of up to 64.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace atlas::core {

/// CRC-64 with the polynomial of ECMA-182 as the XZ file format uses it ("123456789" gives
/// 0x995dc9bbdf1939fa). Over parts: Crc64(b, Crc64(a)) is that of a and b together.
inline uint64_t Crc64(std::string_view bytes, uint64_t before = 0) {
  static constexpr auto kTable = [] {
    std::array<std::array<uint64_t, 256>, 8> table{};
    for (uint64_t i = 0; i < 256; ++i) {
      uint64_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xc96c5795d7870f42u : 0u);
      table[0][i] = crc;
    }
    for (size_t k = 1; k < 8; ++k) {
      for (size_t i = 0; i < 256; ++i) {
        table[k][i] = table[0][table[k - 1][i] & 0xff] ^ (table[k - 1][i] >> 8);
      }
    }
    return table;
  }();
  const auto byte = [&](size_t i) { return static_cast<uint64_t>(static_cast<unsigned char>(bytes[i])); };
  uint64_t crc = ~before;
  size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {  // eight tables, so that the steps do not wait for each other
    uint64_t next = 0;
    for (size_t k = 0; k < 8; ++k) next ^= kTable[7 - k][((crc >> (8 * k)) & 0xff) ^ byte(i + k)];
    crc = next;
  }
  for (; i < bytes.size(); ++i) crc = kTable[0][(crc ^ byte(i)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

}  // namespace atlas::core
