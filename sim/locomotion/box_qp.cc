#include "sim/locomotion/box_qp.h"

#include <array>

namespace atlas::sim {
namespace {

constexpr int kMaxSteps = 40;
constexpr int kMaxHalvings = 25;
constexpr double kGradientTolerance = 1e-7;
constexpr double kSufficientDecrease = 0.1;

struct FreeSet {
  std::array<int, kMaxQpSize> index;
  int size = 0;
  double largest_gradient = 0.0;
};

/// Variables that are not held at a bound by their gradient.
FreeSet FindFree(const QpVector& x, const QpVector& gradient, const QpVector& lower, const QpVector& upper) {
  FreeSet free;
  for (int i = 0; i < x.size(); ++i) {
    const bool held = (x[i] <= lower[i] && gradient[i] > 0.0) || (x[i] >= upper[i] && gradient[i] < 0.0);
    if (held) continue;
    free.index[static_cast<size_t>(free.size++)] = i;
    free.largest_gradient = std::max(free.largest_gradient, std::abs(gradient[i]));
  }
  return free;
}

/// Newton's step in the free variables, zero in the others.
QpVector NewtonStep(const QpMatrix& H, const QpVector& gradient, const FreeSet& free) {
  QpMatrix H_free(free.size, free.size);
  QpVector g_free(free.size);
  for (int a = 0; a < free.size; ++a) {
    const int i = free.index[static_cast<size_t>(a)];
    g_free[a] = gradient[i];
    for (int b = 0; b < free.size; ++b) H_free(a, b) = H(i, free.index[static_cast<size_t>(b)]);
  }
  H_free.llt().solveInPlace(g_free);
  QpVector step = QpVector::Zero(gradient.size());
  for (int a = 0; a < free.size; ++a) step[free.index[static_cast<size_t>(a)]] = -g_free[a];
  return step;
}

}  // namespace

int SolveBoxQp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
               QpVector* x) {
  *x = x->cwiseMax(lower).cwiseMin(upper);
  QpVector gradient = H * *x + g;
  for (int step = 0; step < kMaxSteps; ++step) {
    const FreeSet free = FindFree(*x, gradient, lower, upper);
    if (free.size == 0 || free.largest_gradient < kGradientTolerance) return step;
    const QpVector direction = NewtonStep(H, gradient, free);
    double scale = 1.0;
    bool moved = false;
    for (int halving = 0; halving < kMaxHalvings && !moved; ++halving, scale *= 0.5) {
      const QpVector trial = (*x + scale * direction).cwiseMax(lower).cwiseMin(upper);
      const QpVector change = trial - *x;
      const QpVector H_change = H * change;
      const double slope = gradient.dot(change);
      if (slope + 0.5 * change.dot(H_change) > kSufficientDecrease * slope || slope >= 0.0) continue;
      *x = trial;
      gradient += H_change;
      moved = true;
    }
    if (!moved) return step;
  }
  return kMaxSteps;
}

}  // namespace atlas::sim
