#include "core/rng.h"

#include <cmath>

#include "core/geometry.h"

namespace atlas::core {
namespace {

uint64_t SplitMix(uint64_t& state) {
  uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

double ToUnit(uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

double BoxMuller(double u, double v) {
  return std::sqrt(-2.0 * std::log(1.0 - u)) * std::cos(2.0 * kPi * v);
}

uint64_t Rotl(uint64_t x, int k) {
  return (x << k) | (x >> (64 - k));
}

}  // namespace

Rng::Rng(uint64_t seed) : seed_(seed) {
  uint64_t mixer = seed;
  for (uint64_t& word : state_) word = SplitMix(mixer);
}

Rng Rng::Split(std::string_view name) const {
  uint64_t hash = 0xcbf29ce484222325ULL ^ seed_;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return Rng(SplitMix(hash));
}

uint64_t Rng::Next() {
  const uint64_t result = Rotl(state_[0] + state_[3], 23) + state_[0];
  const uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = Rotl(state_[3], 45);
  return result;
}

double Rng::Uniform() {
  return ToUnit(Next());
}
double Rng::Uniform(double lo, double hi) {
  return lo + (hi - lo) * Uniform();
}
int Rng::UniformInt(int n) {
  return static_cast<int>(Next() % static_cast<uint64_t>(n));
}
double Rng::Normal() {
  const double u = Uniform(), v = Uniform();
  return BoxMuller(u, v);
}

uint64_t HashCounter(uint64_t seed, uint64_t index) {
  uint64_t state = seed ^ (index * 0xd1342543de82ef95ULL);
  return SplitMix(state);
}
double UniformAt(uint64_t seed, uint64_t index) {
  return ToUnit(HashCounter(seed, index));
}
double NormalAt(uint64_t seed, uint64_t index) {
  return BoxMuller(UniformAt(seed, 2 * index), UniformAt(seed, 2 * index + 1));
}

}  // namespace atlas::core
