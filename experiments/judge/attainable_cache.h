// Cache files of attainable sets: packed bits with a checksum.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "experiments/judge/attainable.h"

namespace atlas::experiments {

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
