#include "tests/fuzz/mutate.h"

#include <cstring>

namespace atlas::fuzz {
namespace {

using core::Rng;

size_t Place(const std::string& bytes, Rng* rng) {
  if (bytes.empty()) return 0;
  // Headers stand first: half of all damage goes there.
  const size_t span = rng->Uniform() < 0.5 ? std::min<size_t>(bytes.size(), 256) : bytes.size();
  return static_cast<size_t>(rng->UniformInt(static_cast<int>(span)));
}

size_t Length(const std::string& bytes, size_t from, Rng* rng) {
  const size_t most = std::min<size_t>(bytes.size() - from, rng->Uniform() < 0.7 ? 16 : 4096);
  return most == 0 ? 0 : 1 + static_cast<size_t>(rng->UniformInt(static_cast<int>(most)));
}

/// Replaces a run of digits by a number that counts and sizes should not be.
void EditNumber(std::string* bytes, Rng* rng) {
  static const char* const kNumbers[] = {"0",
                                         "1",
                                         "-1",
                                         "3",
                                         "4096",
                                         "65536",
                                         "1000000000",
                                         "2147483647",
                                         "2147483648",
                                         "4294967295",
                                         "4294967296",
                                         "9223372036854775808",
                                         "18446744073709551616",
                                         "99999999999999999999999999",
                                         "nan",
                                         "inf",
                                         "-inf",
                                         "1e308",
                                         "1e-320",
                                         "0x10",
                                         "",
                                         "1e999"};
  const size_t from = bytes->find_first_of("0123456789", Place(*bytes, rng));
  if (from == std::string::npos) return;
  size_t to = from;
  while (to < bytes->size() && (*bytes)[to] >= '0' && (*bytes)[to] <= '9') ++to;
  bytes->replace(from, to - from, kNumbers[rng->UniformInt(static_cast<int>(std::size(kNumbers)))]);
}

void Overwrite(std::string* bytes, Rng* rng) {
  static const uint64_t kValues[] = {0,
                                     1,
                                     0x7f,
                                     0x80,
                                     0xff,
                                     0xffff,
                                     0x7fffffff,
                                     0x80000000,
                                     0xffffffff,
                                     0x100000000,
                                     0x7fffffffffffffff,
                                     0x8000000000000000,
                                     0xffffffffffffffff,
                                     0x7ff0000000000000,
                                     0x7f800000};
  const uint64_t value = kValues[rng->UniformInt(static_cast<int>(std::size(kValues)))];
  const size_t size = size_t{1} << rng->UniformInt(4), at = Place(*bytes, rng);
  if (bytes->size() - at >= size) std::memcpy(bytes->data() + at, &value, size);
}

void DamageOnce(const std::vector<std::string>& seeds, std::string* bytes, Rng* rng) {
  const size_t at = Place(*bytes, rng);
  switch (rng->UniformInt(9)) {
    case 0:
      if (!bytes->empty()) (*bytes)[at] = static_cast<char>((*bytes)[at] ^ (1 << rng->UniformInt(8)));
      break;
    case 1:
      if (!bytes->empty()) (*bytes)[at] = static_cast<char>(rng->UniformInt(256));
      break;
    case 2:
      bytes->resize(rng->Uniform() < 0.5 ? at : bytes->size() - std::min<size_t>(bytes->size(), 1 + at % 16));
      break;
    case 3:
      bytes->erase(at, Length(*bytes, at, rng));
      break;
    case 4:
      bytes->insert(at, bytes->substr(at, Length(*bytes, at, rng)));
      break;
    case 5:
      bytes->insert(
          at, std::string(static_cast<size_t>(rng->UniformInt(40)), static_cast<char>(rng->UniformInt(256))));
      break;
    case 6: {
      const std::string& other = seeds[static_cast<size_t>(rng->UniformInt(static_cast<int>(seeds.size())))];
      const size_t from = Place(other, rng);
      bytes->replace(at, Length(*bytes, at, rng), other.substr(from, Length(other, from, rng)));
      break;
    }
    case 7:
      EditNumber(bytes, rng);
      break;
    default:
      Overwrite(bytes, rng);
  }
}

}  // namespace

std::string Mutated(const std::vector<std::string>& seeds, Rng* rng) {
  std::string bytes = seeds[static_cast<size_t>(rng->UniformInt(static_cast<int>(seeds.size())))];
  const int damages = rng->Uniform() < 0.5 ? 1 : 2 + rng->UniformInt(3);
  for (int i = 0; i < damages; ++i) DamageOnce(seeds, &bytes, rng);
  return bytes;
}

}  // namespace atlas::fuzz
