#include "mapping/slam/graph_solver.h"

#include <ceres/ceres.h>
#include <ceres/manifold.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/stopwatch.h"
#include "mapping/slam/edge_terms.h"

namespace atlas::mapping {
namespace {

using core::Mat6;
using core::Pose;
using core::Vec6;

// Ceres sees a pose as the 16 numbers of its matrix and asks cost functions for derivatives by these, which
// it multiplies by those of Plus. Only the product counts: cost functions write derivatives by the tangent
// into the first six columns, and Plus claims that these six numbers are the tangent.
constexpr int kPoseNumbers = 16;
using Matrix4Map = Eigen::Map<const Eigen::Matrix4d>;

Pose PoseAt(const double* numbers) {
  Pose T;
  T.matrix() = Matrix4Map(numbers);
  return T;
}

/// T Exp(delta) with all six degrees of freedom, or with x, y and yaw.
class RightPerturbation final : public ceres::Manifold {
 public:
  explicit RightPerturbation(bool planar)
      : rows_(planar ? std::vector<int>{0, 1, 5} : std::vector<int>{0, 1, 2, 3, 4, 5}) {}

  int AmbientSize() const override { return kPoseNumbers; }
  int TangentSize() const override { return static_cast<int>(rows_.size()); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Vec6 xi = Vec6::Zero();
    for (size_t k = 0; k < rows_.size(); ++k) xi[rows_[k]] = delta[k];
    Eigen::Map<Eigen::Matrix4d>(x_plus_delta, 4, 4) = (PoseAt(x) * core::Exp(xi)).matrix();
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    const size_t columns = rows_.size();
    std::fill_n(jacobian, kPoseNumbers * columns, 0.0);
    for (size_t k = 0; k < columns; ++k) jacobian[static_cast<size_t>(rows_[k]) * columns + k] = 1.0;
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Vec6 xi = core::Log(PoseAt(x).inverse() * PoseAt(y));
    for (size_t k = 0; k < rows_.size(); ++k) y_minus_x[k] = xi[rows_[k]];
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    std::fill_n(jacobian, kPoseNumbers * rows_.size(), 0.0);
    for (size_t k = 0; k < rows_.size(); ++k)
      jacobian[k * kPoseNumbers + static_cast<size_t>(rows_[k])] = 1.0;
    return true;
  }

 private:
  std::vector<int> rows_;
};

template <int kRows>
void WriteJacobian(const Eigen::Matrix<double, kRows, 6>& J, double* out) {
  Eigen::Map<Eigen::Matrix<double, kRows, kPoseNumbers, Eigen::RowMajor>> map(out);
  map.setZero();
  map.template leftCols<6>() = J;
}

/// L^T e of the log-map or of g2o's error, where the weighted information is L L^T.
class TangentFactor final : public ceres::SizedCostFunction<6, kPoseNumbers, kPoseNumbers> {
 public:
  TangentFactor(const PoseEdge& edge, double weight, CostConvention cost, bool planar)
      : edge_(edge), whitening_((weight * edge.information).llt().matrixU()), cost_(cost), planar_(planar) {}

  bool Evaluate(const double* const* poses, double* residuals, double** jacobians) const override {
    const Pose T_from = PoseAt(poses[0]), T_to = PoseAt(poses[1]);
    const EdgeTerms<6> terms = cost_ == CostConvention::kG2o ? G2oTerms(edge_, T_from, T_to, planar_)
                                                             : LogMapTerms(edge_, T_from, T_to);
    Eigen::Map<Vec6>(residuals, 6) = whitening_ * terms.error;
    if (jacobians && jacobians[0]) WriteJacobian<6>(whitening_ * terms.by_from, jacobians[0]);
    if (jacobians && jacobians[1]) WriteJacobian<6>(whitening_ * terms.by_to, jacobians[1]);
    return true;
  }

 private:
  PoseEdge edge_;
  Mat6 whitening_;
  CostConvention cost_;
  bool planar_;
};

class ChordalFactor final : public ceres::SizedCostFunction<12, kPoseNumbers, kPoseNumbers> {
 public:
  ChordalFactor(const PoseEdge& edge, double weight, bool planar)
      : edge_(edge), weights_(ChordalWeightsOf(edge, planar)) {
    weights_.kappa *= weight;
    weights_.tau *= weight;
  }

  bool Evaluate(const double* const* poses, double* residuals, double** jacobians) const override {
    const EdgeTerms<12> terms = ChordalTerms(edge_, PoseAt(poses[0]), PoseAt(poses[1]), weights_);
    Eigen::Map<Eigen::Matrix<double, 12, 1>>(residuals, 12) = terms.error;
    if (jacobians && jacobians[0]) WriteJacobian<12>(terms.by_from, jacobians[0]);
    if (jacobians && jacobians[1]) WriteJacobian<12>(terms.by_to, jacobians[1]);
    return true;
  }

 private:
  PoseEdge edge_;
  ChordalWeights weights_;
};

/// Dynamic covariance scaling as an M-estimator: squared up to Phi, then with the weight
/// (2 Phi / (Phi + s))^2 (MacTavish and Barfoot, "At all costs", CRV 2015).
class DcsLoss final : public ceres::LossFunction {
 public:
  explicit DcsLoss(double phi) : phi_(phi) {}
  void Evaluate(double s, double rho[3]) const override {
    if (s <= phi_) {
      rho[0] = s;
      rho[1] = 1.0;
      rho[2] = 0.0;
      return;
    }
    const double scale = 2.0 * phi_ / (phi_ + s);
    rho[0] = 2.0 * scale * s - phi_;
    rho[1] = scale * scale;
    rho[2] = -2.0 * scale * scale / (phi_ + s);
  }

 private:
  double phi_;
};

/// Ceres's problem over the poses of a graph, in place.
class GraphProblem {
 public:
  GraphProblem(PoseGraph* graph, const SolveOptions& options)
      : manifold_(graph->planar), loss_(LossOf(options)), problem_(Ownerless()) {
    const std::vector<bool> fixed = FixedNodes(*graph);
    for (uint32_t node = 0; node < graph->size(); ++node) {
      double* numbers = graph->T_map_node[node].data();
      problem_.AddParameterBlock(numbers, kPoseNumbers, &manifold_);
      if (fixed[node]) problem_.SetParameterBlockConstant(numbers);
    }
    for (size_t k = 0; k < graph->edges.size(); ++k) {
      const double weight = options.edge_weights.empty() ? 1.0 : options.edge_weights[k];
      if (weight <= 0.0) continue;
      const PoseEdge& edge = graph->edges[k];
      const bool robust = loss_ && edge.kind == EdgeKind::kLoop;
      problem_.AddResidualBlock(Factor(edge, weight, graph->planar, options.cost),
                                robust ? loss_.get() : nullptr, graph->T_map_node[edge.from].data(),
                                graph->T_map_node[edge.to].data());
    }
  }

  ceres::Problem* problem() { return &problem_; }

 private:
  static ceres::Problem::Options Ownerless() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.disable_all_safety_checks = true;
    return options;
  }
  static std::unique_ptr<ceres::LossFunction> LossOf(const SolveOptions& options) {
    if (options.loop_loss == LoopLoss::kDcs) return std::make_unique<DcsLoss>(options.loop_scale);
    if (options.loop_loss == LoopLoss::kSquared) return nullptr;
    return std::make_unique<ceres::CauchyLoss>(std::sqrt(options.loop_scale));
  }
  static ceres::CostFunction* Factor(const PoseEdge& edge, double weight, bool planar, CostConvention cost) {
    if (cost == CostConvention::kChordal) return new ChordalFactor(edge, weight, planar);
    return new TangentFactor(edge, weight, cost, planar);
  }

  RightPerturbation manifold_;
  std::unique_ptr<ceres::LossFunction> loss_;  // null: squared
  ceres::Problem problem_;                     // last: refers to the others
};

/// What goes wrong in Ceres is told by its summary; its log would go to the user's terminal.
void KeepCeresQuiet() {
  [[maybe_unused]] static const bool kOnce = [] {
    FLAGS_minloglevel = google::GLOG_FATAL;
    return true;
  }();
}

ceres::Solver::Options CeresOptions(const SolveOptions& options) {
  ceres::Solver::Options out;
  out.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  out.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  out.max_num_iterations = options.max_iterations;
  out.num_threads = options.threads;
  out.function_tolerance = options.function_tolerance;
  out.gradient_tolerance = 1e-12;
  out.parameter_tolerance = 1e-12;
  out.logging_type = ceres::SILENT;
  return out;
}

/// Many small steps must not wear rotations out.
void Renormalise(PoseGraph* graph) {
  const std::vector<bool> fixed = FixedNodes(*graph);
  for (uint32_t node = 0; node < graph->size(); ++node) {
    if (fixed[node]) continue;
    Pose& T = graph->T_map_node[node];
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  }
}

bool AllFinite(const PoseGraph& graph) {
  return std::all_of(graph.T_map_node.begin(), graph.T_map_node.end(),
                     [](const Pose& T) { return T.matrix().allFinite(); });
}

}  // namespace

SolveOptions OptionsFor(CostConvention cost) {
  SolveOptions options{.cost = cost};
  if (cost == CostConvention::kChordal) options.function_tolerance = 1e-7;
  return options;
}

double CostOf(const PoseGraph& graph, CostConvention cost) {
  if (cost == CostConvention::kChordal) return ChordalCost(graph);
  return cost == CostConvention::kG2o ? G2oChi2(graph) : LogMapCost(graph);
}

SolveReport Optimise(PoseGraph* graph, const SolveOptions& options) {
  const core::Stopwatch watch;
  SolveReport report;
  if (graph->size() == 0 || graph->edges.empty()) {
    report.converged = true;
    report.message = "nothing to optimise";
    return report;
  }
  KeepCeresQuiet();
  const std::vector<Pose> start = graph->T_map_node;
  ceres::Solver::Summary summary;
  {
    GraphProblem problem(graph, options);
    ceres::Solve(CeresOptions(options), problem.problem(), &summary);
  }
  // Ceres minimises half a sum of squares; the other conventions are without the half.
  const double scale = options.cost == CostConvention::kLogMap ? 1.0 : 2.0;
  report.initial_cost = scale * summary.initial_cost;
  report.final_cost = scale * summary.final_cost;
  report.iterations = static_cast<int>(summary.iterations.size()) - 1;
  report.converged = summary.termination_type == ceres::CONVERGENCE;
  report.message = summary.message;
  report.failed = !summary.IsSolutionUsable() || !AllFinite(*graph) || !std::isfinite(summary.final_cost) ||
                  summary.final_cost > summary.initial_cost;
  if (report.failed) {
    graph->T_map_node = start;
    report.final_cost = report.initial_cost;
    report.converged = false;
  } else {
    Renormalise(graph);
  }
  report.time_s = watch.seconds();
  return report;
}

}  // namespace atlas::mapping
