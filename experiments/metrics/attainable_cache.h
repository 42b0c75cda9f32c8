// Cache files of attainable sets: packed bits with a checksum.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "experiments/metrics/attainable.h"

namespace atlas::experiments {

/// A 64-bit hash over bytes, fed piece by piece.
class Fingerprint {
 public:
  void Bytes(const void* data, size_t size);
  template <typename T>
  void Value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Bytes(&value, sizeof(value));
  }
  uint64_t value() const { return state_; }

 private:
  uint64_t state_ = 0x9e3779b97f4a7c15ull;
};

/// Key of everything that an attainable set depends on; threads are not among it.
uint64_t AttainableKey(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth,
                       const robots::RobotSpec& robot, const core::LidarModel& lidar,
                       const AttainableOptions& options);

/// The set kept under `key`, or nullopt when the file is missing, cut short, damaged or of other truth.
std::optional<Attainable> ReadAttainable(const std::filesystem::path& path, uint64_t key,
                                         size_t truth_points);
/// Written whole or not at all. @throws InputError when the path cannot be written.
void WriteAttainable(const std::filesystem::path& path, uint64_t key, const Attainable& set);

}  // namespace atlas::experiments
