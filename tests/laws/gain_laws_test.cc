// Every entry of the gain catalogue is held to the laws that it declares.
#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.h"
#include "planner/gain/gain.h"

namespace atlas::planner {
namespace {

using mapping::RayEnd;
using mapping::RaySample;

constexpr double kRes = 0.05;

struct RandomRay {
  std::vector<RaySample> samples;
  RayEnd end = RayEnd::kVoid;
};

/// Runs of free and unknown voxels, ended by a surface or not.
RandomRay DrawRay(core::Rng* rng, bool certain) {
  RandomRay ray;
  const int voxels = 1 + rng->UniformInt(60);
  bool free = rng->UniformInt(2) == 0;
  for (int i = 0; i < voxels; ++i) {
    if (rng->UniformInt(8) == 0) free = !free;
    const double p = certain              ? 0.0
                     : free               ? rng->Uniform(0.02, 0.19)
                     : rng->UniformInt(3) ? 0.5
                                          : rng->Uniform(0.2, 0.8);
    const float behind =
        !certain && p >= 0.2 && rng->UniformInt(3) == 0 ? static_cast<float>(rng->UniformInt(12)) : 0.0f;
    ray.samples.push_back({static_cast<float>(p), static_cast<float>(rng->Uniform(0.2, 1.7) * kRes),
                           1 + rng->Next() % 100000, behind, 1});
  }
  if (rng->UniformInt(2) == 0) {
    ray.end = RayEnd::kOccupied;
    ray.samples.push_back(
        {certain ? 1.0f : 0.95f, static_cast<float>(kRes), 1 + rng->Next() % 100000, 0.0f, 1});
  }
  return ray;
}

std::vector<RandomRay> DrawView(uint64_t seed, bool certain) {
  core::Rng rng(seed);
  std::vector<RandomRay> rays(1 + static_cast<size_t>(rng.UniformInt(40)));
  for (RandomRay& ray : rays) ray = DrawRay(&rng, certain);
  return rays;
}

double GainOf(Gain* gain, const std::vector<RandomRay>& rays) {
  gain->BeginView();
  for (const RandomRay& ray : rays) gain->AddRay(ray.samples, ray.end, 3.0);
  return gain->FinishView();
}

class GainLaw : public ::testing::TestWithParam<std::string> {
 protected:
  const GainEntry& entry() const { return FindGain(GetParam()); }
};

// Laws that a gain declares.
class ZeroOnCertainRaysLaw : public GainLaw {};
class AtMostOcclusionAwareLaw : public GainLaw {};
class IndependentOfVoxelSizeLaw : public GainLaw {};

std::vector<std::string> Declaring(bool GainLaws::*law) {
  std::vector<std::string> names;
  for (const GainEntry& entry : GainCatalog()) {
    if (entry.laws.*law) names.push_back(entry.name);
  }
  return names;
}

TEST_P(GainLaw, IsFiniteAndNeverNegative) {
  const auto gain = entry().build(kRes);
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const double value = GainOf(gain.get(), DrawView(seed, false));
    EXPECT_TRUE(std::isfinite(value) && value >= 0.0) << value;
  }
  EXPECT_EQ(GainOf(gain.get(), {}), 0.0) << "a view without rays";
  EXPECT_EQ(GainOf(gain.get(), {RandomRay{}}), 0.0) << "a ray without voxels";
}

TEST_P(ZeroOnCertainRaysLaw, CertainRayGainsNothing) {
  const auto gain = entry().build(kRes);
  for (uint64_t seed = 1; seed <= 50; ++seed) EXPECT_EQ(GainOf(gain.get(), DrawView(seed, true)), 0.0);
}

TEST_P(AtMostOcclusionAwareLaw, NeverExceedsOcclusionAware) {
  const auto gain = entry().build(kRes), ceiling = FindGain("occlusion_aware").build(kRes);
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const auto rays = DrawView(seed, false);
    EXPECT_LE(GainOf(gain.get(), rays), GainOf(ceiling.get(), rays) + 1e-9);
  }
}

TEST_P(IndependentOfVoxelSizeLaw, DoesNotDependOnVoxelSize) {
  const auto coarse = entry().build(kRes), fine = entry().build(kRes / 4.0);
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const auto rays = DrawView(seed, false);
    auto split = rays;
    for (RandomRay& ray : split) {
      std::vector<RaySample> pieces;
      for (RaySample v : ray.samples) {
        v.length_m /= 4.0f;
        pieces.insert(pieces.end(), v.occupancy > 0.8f ? 1 : 4, v);
      }
      ray.samples = pieces;
    }
    EXPECT_NEAR(GainOf(fine.get(), split), GainOf(coarse.get(), rays),
                1e-5 * (1.0 + GainOf(coarse.get(), rays)));
  }
}

/// A gain sees occupancies, lengths and keys, none of which a rigid motion changes but for the keys' values
/// and the order in which rays come.
TEST_P(GainLaw, DoesNotDependOnRayOrderOrKeyValues) {
  const auto gain = entry().build(kRes);
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const auto rays = DrawView(seed, false);
    std::vector<RandomRay> moved(rays.rbegin(), rays.rend());
    for (RandomRay& ray : moved) {
      for (RaySample& v : ray.samples) v.key = v.key * 0x9e3779b97f4a7c15ULL + 12345;
    }
    const double value = GainOf(gain.get(), rays);
    EXPECT_NEAR(GainOf(gain.get(), moved), value, 1e-9 * (1.0 + value));
  }
}

/// What a trace may join where nobody reads it (mapping::TraceLimits).
std::vector<RaySample> JoinedFor(const GainReads& reads, std::vector<RaySample> voxels) {
  std::vector<RaySample> joined;
  mapping::TraceLimits limits;
  limits.each_free = reads.each_free;
  limits.each_unmeasured = reads.each_unmeasured;
  mapping::RaySamples met(limits, &joined);
  for (const RaySample& v : voxels) {
    const float behind = reads.behind_surface && v.occupancy == 0.5f ? v.behind_surface : 0.0f;
    RaySample sample = v;
    sample.behind_surface = behind;
    met.Add(sample);
  }
  return joined;
}

TEST_P(GainLaw, ReadsNoMoreThanItDeclares) {
  const auto gain = entry().build(kRes);
  size_t samples = 0, voxels = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    auto rays = DrawView(seed, false);
    for (RandomRay& ray : rays) {
      for (RaySample& v : ray.samples) v.behind_surface = v.occupancy == 0.5f ? v.behind_surface : 0.0f;
    }
    auto joined = rays;
    for (RandomRay& ray : joined) {
      voxels += ray.samples.size();
      ray.samples = JoinedFor(entry().reads, ray.samples);
      samples += ray.samples.size();
    }
    const double value = GainOf(gain.get(), rays);
    EXPECT_NEAR(GainOf(gain.get(), joined), value, 1e-5 * (1.0 + value)) << seed;
  }
  const GainReads& reads = entry().reads;
  if (!reads.each_free || !reads.each_unmeasured) {
    EXPECT_LT(samples, 0.9 * voxels) << "or nothing was joined";
  }
}

/// Free voxels of one occupancy in a row may come as one sample.
TEST_P(GainLaw, DoesNotDependOnWhetherFreeVoxelsComeAsRuns) {
  const auto gain = entry().build(kRes);
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    core::Rng rng(seed);
    auto runs = DrawView(seed, false);
    auto voxels = runs;
    for (size_t r = 0; r < runs.size(); ++r) {
      voxels[r].samples.clear();
      for (RaySample& run : runs[r].samples) {
        if (run.occupancy < 0.2f) run.voxels = 1 + static_cast<uint32_t>(rng.UniformInt(40));
        RaySample voxel = run;
        voxel.voxels = 1;
        voxel.length_m = run.length_m / static_cast<float>(run.voxels);
        voxels[r].samples.insert(voxels[r].samples.end(), run.voxels, voxel);
      }
    }
    const double value = GainOf(gain.get(), voxels);
    EXPECT_NEAR(GainOf(gain.get(), runs), value, 1e-6 * (1.0 + value));
  }
}

TEST_P(GainLaw, ForgetsThePreviousView) {
  const auto gain = entry().build(kRes), fresh = entry().build(kRes);
  const auto first = DrawView(11, false), second = DrawView(12, false);
  GainOf(gain.get(), first);
  EXPECT_EQ(GainOf(gain.get(), second), GainOf(fresh.get(), second));
}

TEST_P(GainLaw, HasADocLine) {
  EXPECT_GT(entry().doc.size(), 20u);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, GainLaw, ::testing::ValuesIn(GainNames()));
INSTANTIATE_TEST_SUITE_P(Declared, ZeroOnCertainRaysLaw,
                         ::testing::ValuesIn(Declaring(&GainLaws::zero_on_certain_rays)));
INSTANTIATE_TEST_SUITE_P(Declared, AtMostOcclusionAwareLaw,
                         ::testing::ValuesIn(Declaring(&GainLaws::at_most_occlusion_aware)));
INSTANTIATE_TEST_SUITE_P(Declared, IndependentOfVoxelSizeLaw,
                         ::testing::ValuesIn(Declaring(&GainLaws::independent_of_voxel_size)));

}  // namespace
}  // namespace atlas::planner
