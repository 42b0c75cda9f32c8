// The same map whatever the machine.
#include <gtest/gtest.h>

#include "mapping/integrator/simd_target.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

template <typename Field>
class IntegratorRepeats : public ::testing::Test {
 public:
  void TearDown() override { LimitSimd(""); }

  std::vector<uint8_t> Digest(const IntegratorParams& params) const {
    return tests::DigestOf(tests::MapOf<Field>(spins_, lidar_, params, 0.07));
  }

  core::LidarModel lidar_ = tests::SmallLidar(16, 301);
  core::Rng noise_{5};
  std::vector<core::SpinEvent> spins_ = tests::WalkThrough(tests::FurnishedRoom(), lidar_, 3, &noise_);
};
using Fields = ::testing::Types<OccupancyField, TsdfField>;
TYPED_TEST_SUITE(IntegratorRepeats, Fields);

TYPED_TEST(IntegratorRepeats, SameMapOnEverySimdTarget) {
  const std::vector<std::string> targets = SimdTargets();
  ASSERT_FALSE(targets.empty());
  for (const double skim_cosine : {0.0, 0.5}) {
    IntegratorParams params;
    params.skim_cosine = skim_cosine;
    LimitSimd("scalar");
    EXPECT_EQ(SimdInUse(), "scalar");
    const auto expected = this->Digest(params);
    EXPECT_GT(expected.size(), 100000u);
    for (const std::string& target : targets) {
      LimitSimd(target);
      EXPECT_EQ(SimdInUse(), target);
      EXPECT_TRUE(this->Digest(params) == expected) << target;
    }
  }
  EXPECT_THROW(LimitSimd("mmx"), std::runtime_error);
}

TYPED_TEST(IntegratorRepeats, SameMapForAnyNumberOfThreads) {
  IntegratorParams params;
  params.skim_cosine = 0.5;
  const auto expected = this->Digest(params);
  for (const int threads : {2, 4}) {
    params.threads = threads;
    EXPECT_TRUE(this->Digest(params) == expected) << threads;
  }
}

TYPED_TEST(IntegratorRepeats, SummariesAreCurrentAfterEveryScan) {
  auto map = tests::MapOf<TypeParam>(this->spins_, this->lidar_, {}, 0.07);
  for (const auto* seen : map.Chunks()) {
    auto* chunk = map.Find(seen->key);
    const auto level4 = chunk->level4;
    const auto level6 = chunk->level6;
    BlockMask all;
    all.bits.fill(~uint64_t{0});
    map.Propagate(chunk, all);
    EXPECT_TRUE(level4 == chunk->level4);
    EXPECT_TRUE(level6 == chunk->level6);
  }
}

}  // namespace
}  // namespace atlas::mapping
