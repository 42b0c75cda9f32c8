// Randomness is passed, never global: one run seed, child streams split by name.
#pragma once

#include <cstdint>
#include <string_view>

namespace atlas::core {

/// Deterministic generator (xoshiro256++), the same on every machine. Copyable; a copy repeats the stream.
class Rng {
 public:
  explicit Rng(uint64_t seed);

  /// An independent stream named `name`. Does not advance this one.
  Rng Split(std::string_view name) const;

  uint64_t Next();
  double Uniform();                      ///< in [0, 1)
  double Uniform(double lo, double hi);  ///< in [lo, hi)
  int UniformInt(int n);                 ///< in [0, n), n > 0
  double Normal();                       ///< mean 0, standard deviation 1
  uint64_t seed() const { return seed_; }

 private:
  uint64_t seed_;
  uint64_t state_[4];
};

/// Counter-based noise: a value that depends on (seed, index) only, so a parallel loop over indices gives the
/// same numbers with any number of threads.
uint64_t HashCounter(uint64_t seed, uint64_t index);
double UniformAt(uint64_t seed, uint64_t index);  ///< in [0, 1)
double NormalAt(uint64_t seed, uint64_t index);   ///< mean 0, standard deviation 1

}  // namespace atlas::core
