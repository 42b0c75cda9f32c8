#include <gtest/gtest.h>

#include "core/rng.h"
#include "sim/locomotion/box_qp.h"

namespace atlas::sim {
namespace {

double Cost(const QpMatrix& H, const QpVector& g, const QpVector& x) {
  return 0.5 * x.dot(H * x) + g.dot(x);
}

/// Every assignment of variables to lower bound, upper bound and free: the best feasible stationary point.
QpVector EnumerateActiveSets(const QpMatrix& H, const QpVector& g, const QpVector& lo, const QpVector& up) {
  const int n = static_cast<int>(g.size());
  int combinations = 1;
  for (int i = 0; i < n; ++i) combinations *= 3;
  QpVector best = lo;
  for (int code = 0; code < combinations; ++code) {
    QpVector x = QpVector::Zero(n);
    std::vector<int> free;
    for (int i = 0, c = code; i < n; ++i, c /= 3) {
      if (c % 3 == 0) free.push_back(i);
      if (c % 3 == 1) x[i] = lo[i];
      if (c % 3 == 2) x[i] = up[i];
    }
    if (!free.empty()) {
      const auto size = static_cast<Eigen::Index>(free.size());
      Eigen::MatrixXd H_free(size, size);
      Eigen::VectorXd rhs(size);
      const QpVector pull = H * x + g;
      for (Eigen::Index a = 0; a < size; ++a) {
        rhs[a] = -pull[free[static_cast<size_t>(a)]];
        for (Eigen::Index b = 0; b < size; ++b) {
          H_free(a, b) = H(free[static_cast<size_t>(a)], free[static_cast<size_t>(b)]);
        }
      }
      const Eigen::VectorXd solution = H_free.fullPivLu().solve(rhs);
      for (Eigen::Index a = 0; a < size; ++a) x[free[static_cast<size_t>(a)]] = solution[a];
    }
    const bool feasible = (x.array() >= lo.array() - 1e-9).all() && (x.array() <= up.array() + 1e-9).all();
    if (feasible && Cost(H, g, x) < Cost(H, g, best)) best = x;
  }
  return best;
}

TEST(BoxQp, EqualsTheBestOfAllActiveSets) {
  core::Rng rng(11);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + rng.UniformInt(5);
    QpMatrix A(n, n);
    QpVector g(n), lo(n), up(n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) A(i, j) = rng.Normal();
      g[i] = 5.0 * rng.Normal();
      lo[i] = rng.Uniform(-1.0, 0.5);
      up[i] = lo[i] + rng.Uniform(0.0, 2.0);
    }
    const QpMatrix H = A.transpose() * A + 0.05 * QpMatrix::Identity(n, n);
    QpVector x = QpVector::Zero(n);
    SolveBoxQp(H, g, lo, up, &x);
    const QpVector oracle = EnumerateActiveSets(H, g, lo, up);
    EXPECT_LT((x - oracle).norm(), 1e-5) << "trial " << trial;
  }
}

TEST(BoxQp, UnboundedProblemTakesOneNewtonStep) {
  const QpMatrix H = QpMatrix::Identity(3, 3) * 2.0;
  const QpVector g = QpVector::Constant(3, -4.0);
  QpVector x = QpVector::Zero(3);
  EXPECT_EQ(SolveBoxQp(H, g, QpVector::Constant(3, -100.0), QpVector::Constant(3, 100.0), &x), 1);
  EXPECT_LT((x - QpVector::Constant(3, 2.0)).norm(), 1e-12);
}

}  // namespace
}  // namespace atlas::sim
