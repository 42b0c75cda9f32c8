// How many processors this process may use.
#pragma once

#include <filesystem>

namespace atlas::core {

/// Whole CPUs worth of time: those of the process's affinity mask (taskset, Slurm), and no more than the
/// quotas of its control groups (containers) allow, rounded up. At least 1.
/// @param root the root of the file system, below which /proc and /sys/fs/cgroup are read; another in tests.
int AvailableCpus(const std::filesystem::path& root = "/");

}  // namespace atlas::core
