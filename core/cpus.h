// How many processors this process may use.
#pragma once

#include <filesystem>

namespace atlas::core {

/// Whole CPUs worth of time: those of the process's affinity mask (taskset, Slurm), and no more than the
/// quotas of its control groups (containers) allow, rounded up. At least 1.
int AvailableCpus();

/// Of `cpus`, as many as the quotas allow that are found below `root` (proc/self/cgroup, sys/fs/cgroup), at
/// least 1.
int CpusWithinQuota(int cpus, const std::filesystem::path& root);

}  // namespace atlas::core
