#include "core/cpus.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include "core/files.h"

namespace atlas::core {
namespace {

namespace fs = std::filesystem;

class CpusTest : public ::testing::Test {
 protected:
  CpusTest() {
    sched_getaffinity(0, sizeof before_, &before_);
    Write("proc/self/cgroup", "0::/\n");
  }
  ~CpusTest() override {
    sched_setaffinity(0, sizeof before_, &before_);
    fs::remove_all(root_);
  }
  void Write(const std::string& name, const std::string& text) const {
    WriteFileAtomically(root_ / name, text);
  }
  int Found() const { return CpusWithinQuota(kCpus, root_); }

  static constexpr int kCpus = 8;

  const fs::path root_ = fs::temp_directory_path() / ("atlas_cpus_" + std::to_string(getpid()));
  cpu_set_t before_;
};

TEST_F(CpusTest, AreThoseOfTheAffinityMask) {
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++i) {
    if (CPU_ISSET(i, &before_)) CPU_SET(i, &one);
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(AvailableCpus(), 1);
}

TEST_F(CpusTest, AreNoMoreThanTheQuotaOfTheGroupOrOfAnyGroupAboveIt) {
  Write("proc/self/cgroup", "0::/jobs/one\n");
  Write("sys/fs/cgroup/jobs/one/cpu.max", "max 100000\n");
  EXPECT_EQ(Found(), kCpus);
  Write("sys/fs/cgroup/jobs/one/cpu.max", "50000 100000\n");
  EXPECT_EQ(Found(), 1);
  Write("sys/fs/cgroup/jobs/one/cpu.max", "max 100000\n");
  Write("sys/fs/cgroup/jobs/cpu.max", "100000 100000\n");
  EXPECT_EQ(Found(), 1);
  Write("sys/fs/cgroup/jobs/cpu.max", "110000 100000\n");  // a part of a CPU counts as one
  EXPECT_EQ(Found(), 2);
}

TEST_F(CpusTest, OfAContainerAreThoseOfItsRoot) {
  Write("proc/self/cgroup", "0::/a/path/of/the/host\n");
  Write("sys/fs/cgroup/cpu.max", "100000 100000\n");
  EXPECT_EQ(Found(), 1);
}

TEST_F(CpusTest, FollowTheQuotaOfTheFirstVersionOfControlGroups) {
  Write("proc/self/cgroup", "3:cpuset:/\n2:cpu,cpuacct:/job\n0::/\n");
  for (const std::string mount : {"cpu,cpuacct", "cpu"}) {
    const std::string job = "sys/fs/cgroup/" + mount + "/job/";
    Write(job + "cpu.cfs_quota_us", "-1\n");
    Write(job + "cpu.cfs_period_us", "100000\n");
    EXPECT_EQ(Found(), kCpus) << mount;
    Write(job + "cpu.cfs_quota_us", "100000\n");
    EXPECT_EQ(Found(), 1) << mount;
    fs::remove_all(root_ / "sys");
  }
}

TEST_F(CpusTest, BrokenFilesMeanNoQuota) {
  for (const char* text : {"", "x", "100000", "0 100000", "100000 0", "-5 7"}) {
    Write("sys/fs/cgroup/cpu.max", text);
    EXPECT_EQ(Found(), kCpus) << text;
  }
}

}  // namespace
}  // namespace atlas::core
