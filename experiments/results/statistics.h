// Small statistics for tables: moments, percentiles, rank correlation.
#pragma once

#include <span>
#include <vector>

namespace atlas::experiments {

/// Moments of a sample. `stddev` is the sample's (n - 1), 0 for fewer than two values.
struct SampleStatistics {
  int count = 0;
  double mean = 0.0;
  double stddev = 0.0;
  double min = 0.0;
  double max = 0.0;
};
SampleStatistics Describe(std::span<const double> values);

/// t with P(|T| < t) = `confidence` for Student's T of `degrees` degrees of freedom (0.95, 4: 2.776).
/// @pre 0 < confidence < 1, degrees >= 1
double StudentT(double confidence, int degrees);
/// Half width of the 95 % confidence interval of the sample's mean: t s / sqrt(n). @pre s.count >= 2
double ConfidenceHalfWidth(const SampleStatistics& s);

/// The `share` quantile (0.95 = p95) with linear interpolation between order statistics. 0 for no values.
/// @pre 0 <= share <= 1
double Percentile(std::span<const double> values, double share);

/// Ranks from 1, ties sharing their mean rank.
std::vector<double> Ranks(std::span<const double> values);

/// Spearman's rank correlation in [-1, 1]; 0 where either side is constant or shorter than two.
/// @pre equally long
double Spearman(std::span<const double> a, std::span<const double> b);

}  // namespace atlas::experiments
