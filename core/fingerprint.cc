#include "core/fingerprint.h"

#include <fmt/format.h>

#include <cstring>

namespace atlas::core {

void Fingerprint::Bytes(const void* data, size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  const auto mix = [this](uint64_t word) {
    state_ = (state_ ^ word) * 0xff51afd7ed558ccdull;
    state_ ^= state_ >> 32;
  };
  size_t i = 0;
  for (; i + 8 <= size; i += 8) {
    uint64_t word;
    std::memcpy(&word, bytes + i, 8);
    mix(word);
  }
  uint64_t tail = 0;
  if (i < size) std::memcpy(&tail, bytes + i, size - i);
  mix(tail ^ (static_cast<uint64_t>(size) << 56));
}

void Fingerprint::Text(std::string_view text) {
  Value(static_cast<uint64_t>(text.size()));
  Bytes(text.data(), text.size());
}

std::string Fingerprint::Hex() const {
  return fmt::format("{:016x}", state_);
}

}  // namespace atlas::core
