#include "core/cpus.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <thread>

#include "core/errors.h"
#include "core/files.h"
#include "core/text_lines.h"

namespace atlas::core {
namespace fs = std::filesystem;
namespace {

constexpr int kMostCpus = 1 << 16;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

int CpusOfAffinity() {
  for (int size = 1024; size <= kMostCpus; size *= 2) {  // the call fails until the mask is large enough
    cpu_set_t* set = CPU_ALLOC(size);
    const size_t bytes = CPU_ALLOC_SIZE(size);
    const int count = sched_getaffinity(0, bytes, set) == 0 ? CPU_COUNT_S(bytes, set) : 0;
    CPU_FREE(set);
    if (count > 0) return count;
  }
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

std::string TextOf(const fs::path& path) {
  try {
    return ReadFile(path);
  } catch (const InputError&) {
    return "";
  }
}

/// The numbers of a file, until a word that is none ("max").
std::vector<double> NumbersOf(const fs::path& path) {
  const std::string text = TextOf(path);
  std::vector<double> numbers;
  for (const std::string_view word : SplitWords(text)) {
    const auto number = ParseNumber<double>(word);
    if (!number) break;
    numbers.push_back(*number);
  }
  return numbers;
}

/// CPUs that the quota of one group allows: cpu.max of cgroup 2 "QUOTA PERIOD", or the two files of cgroup 1.
double QuotaOf(const fs::path& group) {
  std::vector<double> quota = NumbersOf(group / "cpu.max");
  if (quota.empty()) {
    quota = NumbersOf(group / "cpu.cfs_quota_us");
    const std::vector<double> period = NumbersOf(group / "cpu.cfs_period_us");
    quota.insert(quota.end(), period.begin(), period.end());
  }
  return quota.size() >= 2 && quota[0] > 0.0 && quota[1] > 0.0 ? quota[0] / quota[1] : kNoLimit;
}

/// The least quota of `group` and the groups above it, up to the mount point.
double QuotaUpwards(const fs::path& mount, fs::path group) {
  double least = QuotaOf(mount);
  for (; group.has_relative_path(); group = group.parent_path()) {
    least = std::min(least, QuotaOf(mount / group.relative_path()));
  }
  return least;
}

double QuotaOfProcess(const fs::path& root) {
  const std::string text = TextOf(root / "proc/self/cgroup");
  TextLines lines(text);
  const fs::path cgroups = root / "sys/fs/cgroup";
  double least = kNoLimit;
  while (const auto line = lines.Next()) {  // ID:CONTROLLERS:PATH
    const size_t first = line->find(':'), second = line->find(':', first + 1);
    if (first == std::string_view::npos || second == std::string_view::npos) continue;
    const std::string_view controllers = line->substr(first + 1, second - first - 1);
    const fs::path group = line->substr(second + 1);
    if (controllers.empty()) least = std::min(least, QuotaUpwards(cgroups, group));
    const std::vector<std::string_view> names = SplitWords(controllers, ",");
    if (std::find(names.begin(), names.end(), "cpu") == names.end()) continue;
    least =
        std::min({least, QuotaUpwards(cgroups / "cpu", group), QuotaUpwards(cgroups / controllers, group)});
  }
  return least;
}

}  // namespace

int CpusWithinQuota(int cpus, const fs::path& root) {
  return std::max(1, static_cast<int>(std::min<double>(cpus, std::ceil(QuotaOfProcess(root)))));
}

int AvailableCpus() {
  return CpusWithinQuota(CpusOfAffinity(), "/");
}

}  // namespace atlas::core
