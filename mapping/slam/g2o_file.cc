#include "mapping/slam/g2o_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/errors.h"
#include "core/files.h"
#include "core/text_lines.h"
#include "mapping/slam/chordal_start.h"

namespace atlas::mapping {
namespace {

using core::InputError;
using core::Mat6;
using core::Pose;
using core::Vec3;

constexpr double kQuaternionLengthTolerance = 0.01;
constexpr double kFarthestPosition_m = 1e7;
constexpr double kGreatestInformation = 1e15;
/// Of the smallest eigenvalue once the diagonal is scaled to one.
constexpr double kLeastDefiniteness = 1e-10;
constexpr double kAsymmetryTolerance = 1e-6;

/// Rows of Mat6 that a planar information matrix fills.
constexpr std::array<int, 3> kPlanarRows = {0, 1, 5};

/// A line with a known tag.
struct G2oLine {
  std::string where;  ///< "FILE:LINE: TAG"
  std::vector<std::string_view> words;

  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", where, reason));
  }
  int64_t Id(size_t k) const {
    if (k >= words.size()) Fail(fmt::format("ends before its {}. word, an id", k));
    const auto id = core::ParseNumber<int64_t>(words[k]);
    if (!id) Fail(fmt::format("id '{}' is no integer", words[k].substr(0, 40)));
    return *id;
  }
  double Number(size_t k) const {
    const auto value = core::ParseNumber<double>(words[k]);
    if (!value) Fail(fmt::format("word {}: '{}' is no number", k, words[k].substr(0, 40)));
    if (!std::isfinite(*value)) Fail(fmt::format("word {}: {} is not finite", k, *value));
    return *value;
  }
};

/// A pose of 3 (x y yaw) or 7 numbers (x y z qx qy qz qw) from word `first` on.
Pose PoseOf(const G2oLine& line, size_t first, bool planar) {
  std::array<double, 7> v{};
  for (size_t k = 0; k < (planar ? 3u : 7u); ++k) v[k] = line.Number(first + k);
  const Vec3 t(v[0], v[1], planar ? 0.0 : v[2]);
  if (t.norm() > kFarthestPosition_m)
    line.Fail(fmt::format("position is {:g} m long (limit {:g})", t.norm(), kFarthestPosition_m));
  if (planar) return core::PoseFromXyzYaw(t, v[2]);
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionLengthTolerance)) {
    line.Fail(fmt::format("length of the quaternion (qx qy qz qw) is {:g} (1 within {})", q.norm(),
                          kQuaternionLengthTolerance));
  }
  return core::MakePose(q.normalized().toRotationMatrix(), t);
}

/// The smallest eigenvalue of a symmetric matrix once its diagonal is scaled to one. @pre positive diagonal.
double LeastEigenvalue(const Eigen::MatrixXd& W) {
  const Eigen::VectorXd scale = W.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * W * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .minCoeff();
}

void CheckEntries(const G2oLine& line, const Eigen::MatrixXd& W) {
  const double largest = W.cwiseAbs().maxCoeff();
  if (largest > kGreatestInformation)
    line.Fail(fmt::format("information {:g} is above {:g}", largest, kGreatestInformation));
  for (int i = 0; i < W.rows(); ++i) {
    if (!(W(i, i) > 0.0))
      line.Fail(fmt::format("information is not positive definite: diagonal {} is {:g}", i + 1, W(i, i)));
    for (int j = 0; j < i; ++j) {
      if (std::abs(W(i, j) - W(j, i)) > kAsymmetryTolerance * largest)
        line.Fail(fmt::format("information is not symmetric: {:g} in row {} column {}, {:g} across", W(j, i),
                              j + 1, i + 1, W(i, j)));
    }
  }
}

void CheckDefinite(const G2oLine& line, const Eigen::MatrixXd& W) {
  const double least = LeastEigenvalue(W);
  if (least > kLeastDefiniteness) return;
  line.Fail(
      fmt::format("information is not positive definite: scaled to a diagonal of ones, its smallest "
                  "eigenvalue is {:g} (must be above {:g})",
                  least, kLeastDefiniteness));
}

/// The symmetric matrix of n x n that begins at word `first`.
Eigen::MatrixXd SymmetricMatrixOf(const G2oLine& line, size_t first, int n) {
  const bool is_whole = line.words.size() - first == static_cast<size_t>(n * n);
  Eigen::MatrixXd W(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = is_whole ? 0 : i; j < n; ++j) {
      W(i, j) = line.Number(first++);
      if (!is_whole) W(j, i) = W(i, j);
    }
  }
  CheckEntries(line, W);
  return 0.5 * (W + W.transpose());
}

Mat6 PlanarInformationOf(const G2oLine& line, size_t first) {
  const Eigen::MatrixXd W = SymmetricMatrixOf(line, first, 3);
  CheckDefinite(line, W);
  Mat6 information = Mat6::Identity();  // of what does not count
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j)
      information(kPlanarRows[i], kPlanarRows[j]) = W(static_cast<int>(i), static_cast<int>(j));
  }
  return information;
}

/// Without its cross terms where it is definite only so; counts these.
Mat6 SpatialInformationOf(const G2oLine& line, size_t first, size_t* without_cross_terms) {
  Eigen::MatrixXd W = SymmetricMatrixOf(line, first, 6);
  if (LeastEigenvalue(W) > kLeastDefiniteness) return W;
  CheckDefinite(line, W.topLeftCorner<3, 3>());
  CheckDefinite(line, W.bottomRightCorner<3, 3>());
  W.topRightCorner<3, 3>().setZero();
  W.bottomLeftCorner<3, 3>().setZero();
  ++*without_cross_terms;
  return W;
}

void CheckCount(const G2oLine& line, std::initializer_list<size_t> valid) {
  const size_t count = line.words.size() - 1;
  if (std::find(valid.begin(), valid.end(), count) != valid.end()) return;
  line.Fail(fmt::format("{} numbers ({})", count, fmt::join(valid, " or ")));
}

/// What a file says, before its ids become indices.
class G2oParser {
 public:
  explicit G2oParser(const std::string& file) : file_(file) {}

  void Read(const G2oLine& line) {
    const std::string_view tag = line.words.front();
    if (tag == "VERTEX_SE2" || tag == "VERTEX_SE3:QUAT") return ReadVertex(line, Planar(line));
    if (tag == "EDGE_SE2" || tag == "EDGE_SE3:QUAT") return ReadEdge(line, Planar(line));
    if (tag == "FIX") return ReadFix(line);
    if (result_.skipped++ == 0) result_.first_skipped = tag;
  }

  G2oGraph FinishVertices() {
    if (vertices_.empty())
      throw InputError(fmt::format("{}: holds no vertices VERTEX_SE2 or VERTEX_SE3:QUAT", file_));
    result_.graph.planar = *planar_;
    PlaceNodes();
    return std::move(result_);
  }

  G2oGraph Finish() {
    if (edges_.empty()) {
      const std::string skipped = result_.skipped > 0
                                      ? fmt::format(" ({} lines skipped, the first is '{}')", result_.skipped,
                                                    result_.first_skipped.substr(0, 40))
                                      : "";
      throw InputError(
          fmt::format("{}: holds no edges EDGE_SE2 or EDGE_SE3:QUAT{}: the graph is empty", file_, skipped));
    }
    result_.graph.planar = *planar_;
    result_.has_poses = !vertices_.empty();
    if (!result_.has_poses) {
      for (const Edge& edge : edges_) vertices_[edge.from] = vertices_[edge.to] = Pose::Identity();
    }
    PlaceNodes();
    ConnectEdges();
    CheckConnected();
    TrustBridges();
    if (!result_.has_poses) result_.graph.T_map_node = ChordalStart(result_.graph);
    return std::move(result_);
  }

 private:
  struct Edge {
    std::string where;
    int64_t from, to;
    PoseEdge edge;
  };

  bool Planar(const G2oLine& line) {
    const bool planar = line.words.front().ends_with("SE2");
    if (planar_.value_or(planar) != planar) line.Fail("SE2 and SE3 tags in one file");
    planar_ = planar;
    return planar;
  }

  void ReadVertex(const G2oLine& line, bool planar) {
    CheckCount(line, {planar ? 4u : 8u});
    const int64_t id = line.Id(1);
    if (!vertices_.emplace(id, PoseOf(line, 2, planar)).second)
      line.Fail(fmt::format("id {} is there twice", id));
  }

  void ReadEdge(const G2oLine& line, bool planar) {
    if (planar) {
      CheckCount(line, {11, 14});
    } else {
      CheckCount(line, {30, 45});
    }
    Edge edge{line.where, line.Id(1), line.Id(2), {}};
    if (edge.from == edge.to) line.Fail(fmt::format("leads from node {} to itself", edge.from));
    edge.edge.T_from_to = PoseOf(line, 3, planar);
    edge.edge.information =
        planar ? PlanarInformationOf(line, 6) : SpatialInformationOf(line, 10, &result_.without_cross_terms);
    // Unsigned, since ids may be as far apart as their type allows.
    const uint64_t step = static_cast<uint64_t>(edge.to) - static_cast<uint64_t>(edge.from);
    edge.edge.kind = step == 1 || step == ~uint64_t{0} ? EdgeKind::kOdometry : EdgeKind::kLoop;
    edges_.push_back(std::move(edge));
  }

  void ReadFix(const G2oLine& line) {
    if (line.words.size() < 2) line.Fail("names no id");
    for (size_t k = 1; k < line.words.size(); ++k) fixed_.push_back({line.where, line.Id(k)});
  }

  uint32_t NodeOf(const std::string& where, int64_t id) const {
    const auto found = std::lower_bound(result_.id.begin(), result_.id.end(), id);
    if (found == result_.id.end() || *found != id)
      throw InputError(fmt::format("{}: node {} has no vertex in the file", where, id));
    return static_cast<uint32_t>(found - result_.id.begin());
  }

  void PlaceNodes() {
    for (const auto& [id, T_map_node] : vertices_) {
      result_.id.push_back(id);
      result_.graph.T_map_node.push_back(T_map_node);
    }
    for (const auto& [where, id] : fixed_) result_.graph.fixed.push_back(NodeOf(where, id));
  }

  void ConnectEdges() {
    for (Edge& edge : edges_) {
      edge.edge.from = NodeOf(edge.where, edge.from);
      edge.edge.to = NodeOf(edge.where, edge.to);
      result_.graph.edges.push_back(edge.edge);
    }
  }

  /// Loops that hold pieces of odometry together cannot be doubted.
  void TrustBridges() {
    NodeSets pieces(result_.graph.size());
    for (const PoseEdge& edge : result_.graph.edges) {
      if (edge.kind == EdgeKind::kOdometry) pieces.Join(edge.from, edge.to);
    }
    for (PoseEdge& edge : result_.graph.edges) {
      if (pieces.Join(edge.from, edge.to)) edge.kind = EdgeKind::kOdometry;
    }
  }

  void CheckConnected() const {
    const std::vector<uint32_t> component = ComponentsOf(result_.graph);
    const uint32_t count = *std::max_element(component.begin(), component.end()) + 1;
    if (count == 1) return;
    const auto other = std::find(component.begin(), component.end(), 1u) - component.begin();
    throw InputError(fmt::format("{}: the graph is in {} pieces: no edges lead from node {} to node {}",
                                 file_, count, result_.id.front(), result_.id[static_cast<size_t>(other)]));
  }

  std::string file_;
  G2oGraph result_;
  std::optional<bool> planar_;
  std::map<int64_t, Pose> vertices_;
  std::vector<Edge> edges_;
  std::vector<std::pair<std::string, int64_t>> fixed_;
};

void AppendPose(const Pose& T, bool planar, std::string* out) {
  const Vec3 t = T.translation();
  if (planar) {
    *out += fmt::format(" {} {} {}", t.x(), t.y(), core::YawOf(T.linear()));
    return;
  }
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  *out += fmt::format(" {} {} {} {} {} {} {}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

void AppendEdge(const PoseEdge& edge, const G2oGraph& file, std::string* out) {
  const bool planar = file.graph.planar;
  *out +=
      fmt::format("{} {} {}", planar ? "EDGE_SE2" : "EDGE_SE3:QUAT", file.id[edge.from], file.id[edge.to]);
  AppendPose(edge.T_from_to, planar, out);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      const auto counts = [&](int row) { return !planar || row < 2 || row == 5; };
      if (counts(i) && counts(j)) *out += fmt::format(" {}", edge.information(i, j));
    }
  }
  *out += '\n';
}

template <typename Visit>
void ForEachLine(std::string_view text, const std::string& file, const Visit& visit) {
  core::TextLines lines(text);
  while (const auto line = lines.Next()) {
    G2oLine row{"", core::SplitWords(line->substr(0, line->find('#')))};
    if (row.words.empty()) continue;
    row.where = fmt::format("{}:{}: {}", file, lines.number(), row.words.front().substr(0, 40));
    visit(row);
  }
}

}  // namespace

G2oGraph ParseG2o(std::string_view text, const std::string& file) {
  G2oParser parser(file);
  ForEachLine(text, file, [&](const G2oLine& line) { parser.Read(line); });
  return parser.Finish();
}

G2oGraph ParseG2oVertices(std::string_view text, const std::string& file) {
  G2oParser parser(file);
  ForEachLine(text, file, [&](const G2oLine& line) {
    if (line.words.front().starts_with("VERTEX")) parser.Read(line);
  });
  return parser.FinishVertices();
}

G2oGraph ReadG2oVertices(const std::filesystem::path& path) {
  return ParseG2oVertices(core::ReadFile(path), path.string());
}

G2oGraph ReadG2o(const std::filesystem::path& path) {
  return ParseG2o(core::ReadFile(path), path.string());
}

std::string FormatG2o(const G2oGraph& file) {
  std::string out;
  const bool planar = file.graph.planar;
  for (uint32_t node = 0; node < file.graph.size(); ++node) {
    out += fmt::format("{} {}", planar ? "VERTEX_SE2" : "VERTEX_SE3:QUAT", file.id[node]);
    AppendPose(file.graph.T_map_node[node], planar, &out);
    out += '\n';
  }
  for (const uint32_t node : file.graph.fixed) out += fmt::format("FIX {}\n", file.id[node]);
  for (const PoseEdge& edge : file.graph.edges) AppendEdge(edge, file, &out);
  return out;
}

void WriteG2o(const std::filesystem::path& path, const G2oGraph& file) {
  core::WriteFileAtomically(path, FormatG2o(file));
}

}  // namespace atlas::mapping
