#include "experiments/results/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.h"

namespace atlas::experiments {
namespace {

TEST(Statistics, MomentsOfAKnownSample) {
  const SampleStatistics s = Describe(std::vector<double>{2, 4, 4, 4, 5, 5, 7, 9});
  EXPECT_EQ(s.count, 8);
  EXPECT_DOUBLE_EQ(s.mean, 5.0);
  EXPECT_DOUBLE_EQ(s.stddev, std::sqrt(32.0 / 7.0));
  EXPECT_DOUBLE_EQ(s.min, 2.0);
  EXPECT_DOUBLE_EQ(s.max, 9.0);
  EXPECT_EQ(Describe({}).count, 0);
  EXPECT_EQ(Describe(std::vector<double>{3.0}).stddev, 0.0);
}

TEST(Statistics, StudentTIsThatOfThePrintedTables) {
  const std::pair<int, double> printed[] = {{1, 12.706}, {2, 4.303},  {3, 3.182},  {4, 2.776},
                                            {9, 2.262},  {10, 2.228}, {29, 2.045}, {120, 1.980}};
  for (const auto& [degrees, t] : printed) EXPECT_NEAR(StudentT(0.95, degrees), t, 5e-4) << degrees;
  EXPECT_NEAR(StudentT(0.99, 4), 4.604, 5e-4);
}

TEST(Statistics, ConfidenceIntervalHoldsTheMeanInNineteenOfTwentySamples) {
  core::Rng rng(5);
  int held = 0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    std::vector<double> values(5);
    for (double& value : values) value = 3.0 + 2.0 * rng.Normal();
    const SampleStatistics s = Describe(values);
    held += std::abs(s.mean - 3.0) < ConfidenceHalfWidth(s);
  }
  EXPECT_NEAR(static_cast<double>(held) / kSamples, 0.95, 0.006);  // four standard errors
}

TEST(Statistics, PercentileInterpolatesBetweenOrderStatistics) {
  const std::vector<double> v = {40, 10, 30, 20};
  EXPECT_DOUBLE_EQ(Percentile(v, 0.0), 10.0);
  EXPECT_DOUBLE_EQ(Percentile(v, 1.0), 40.0);
  EXPECT_DOUBLE_EQ(Percentile(v, 0.5), 25.0);
  EXPECT_DOUBLE_EQ(Percentile(v, 0.95), 38.5);
}

TEST(Statistics, TiesShareTheirMeanRank) {
  EXPECT_EQ(Ranks(std::vector<double>{5, 1, 5, 2}), (std::vector<double>{3.5, 1, 3.5, 2}));
}

TEST(Statistics, SpearmanEqualsItsTextbookFormWithoutTies) {
  core::Rng rng(11);
  std::vector<double> a(50), b(50);
  for (int i = 0; i < 50; ++i) {
    a[i] = rng.Uniform();
    b[i] = a[i] + 0.3 * rng.Normal();
  }
  double squares = 0.0;  // 1 - 6 sum d^2 / (n (n^2 - 1))
  for (int i = 0; i < 50; ++i) {
    double rank_a = 1, rank_b = 1;
    for (int k = 0; k < 50; ++k) {
      rank_a += a[k] < a[i];
      rank_b += b[k] < b[i];
    }
    squares += (rank_a - rank_b) * (rank_a - rank_b);
  }
  EXPECT_NEAR(Spearman(a, b), 1.0 - 6.0 * squares / (50.0 * (2500.0 - 1.0)), 1e-12);
  std::vector<double> falling(a);
  for (double& v : falling) v = -std::exp(v);
  EXPECT_NEAR(Spearman(a, falling), -1.0, 1e-12);
  EXPECT_EQ(Spearman(a, std::vector<double>(50, 1.0)), 0.0);
}

}  // namespace
}  // namespace atlas::experiments
