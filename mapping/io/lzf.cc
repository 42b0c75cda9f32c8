#include "mapping/io/lzf.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace atlas::mapping {
namespace {

constexpr size_t kLongestLiteral = 32;
constexpr size_t kLongestCopy = 264;
constexpr size_t kFarthestCopy = 8192;
constexpr size_t kHashBits = 14;

uint8_t Byte(std::string_view bytes, size_t i) {
  return static_cast<uint8_t>(bytes[i]);
}

size_t HashOf(std::string_view bytes, size_t i) {
  const uint32_t three =
      static_cast<uint32_t>(Byte(bytes, i) << 16 | Byte(bytes, i + 1) << 8 | Byte(bytes, i + 2));
  return (three * 2654435761u) >> (32 - kHashBits);
}

void PutLiterals(std::string_view literals, std::string* out) {
  for (size_t i = 0; i < literals.size(); i += kLongestLiteral) {
    const std::string_view run = literals.substr(i, kLongestLiteral);
    out->push_back(static_cast<char>(run.size() - 1));
    out->append(run);
  }
}

void PutCopy(size_t length, size_t distance, std::string* out) {
  const size_t back = distance - 1, code = length - 2;
  out->push_back(static_cast<char>(std::min<size_t>(code, 7) << 5 | back >> 8));
  if (code >= 7) out->push_back(static_cast<char>(code - 7));
  out->push_back(static_cast<char>(back & 0xff));
}

}  // namespace

std::optional<std::string> LzfUnpack(std::string_view packed, size_t size) {
  if (size / (kLongestCopy / 3) > packed.size()) return std::nullopt;
  std::string out;
  out.reserve(size);
  for (size_t i = 0; i < packed.size();) {
    const size_t control = Byte(packed, i++);
    if (control < kLongestLiteral) {
      if (packed.size() - i < control + 1) return std::nullopt;
      out.append(packed.substr(i, control + 1));
      i += control + 1;
    } else {
      size_t length = (control >> 5) + 2;
      if (control >> 5 == 7 && i < packed.size()) length += Byte(packed, i++);
      if (i >= packed.size()) return std::nullopt;
      const size_t distance = ((control & 31) << 8 | Byte(packed, i++)) + 1;
      if (distance > out.size()) return std::nullopt;
      if (length > size - out.size()) return std::nullopt;
      for (size_t k = 0; k < length; ++k) out.push_back(out[out.size() - distance]);
    }
    if (out.size() > size) return std::nullopt;
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

std::string LzfPack(std::string_view bytes) {
  std::array<size_t, size_t{1} << kHashBits> last_seen;
  last_seen.fill(bytes.size());
  std::string out;
  size_t literals_from = 0;
  for (size_t i = 0; i + 2 < bytes.size();) {
    size_t& seen = last_seen[HashOf(bytes, i)];
    const size_t before = seen;
    seen = i;
    size_t length = 0;
    if (before < i && i - before <= kFarthestCopy) {
      const size_t limit = std::min(kLongestCopy, bytes.size() - i);
      while (length < limit && bytes[before + length] == bytes[i + length]) ++length;
    }
    if (length < 3) {
      ++i;
      continue;
    }
    PutLiterals(bytes.substr(literals_from, i - literals_from), &out);
    PutCopy(length, i - before, &out);
    i += length;
    literals_from = i;
  }
  PutLiterals(bytes.substr(literals_from), &out);
  return out;
}

}  // namespace atlas::mapping
