#include "mapping/io/recorded_poses.h"

#include <fmt/format.h>

#include <array>
#include <limits>

#include "core/errors.h"
#include "core/files.h"
#include "core/text_lines.h"

namespace atlas::mapping {
namespace {

using core::InputError;
using core::Mat3;
using core::Pose;
using core::Vec3;

constexpr double kQuaternionTolerance = 0.01;
constexpr double kRotationTolerance = 1e-3;
constexpr double kFarthest_m = 1e7;

/// Where a row of numbers stands, for errors.
struct Row {
  std::string where;  ///< "FILE:LINE"
  std::vector<double> value;
};

[[noreturn]] void Fail(const Row& row, const std::string& reason) {
  throw InputError(fmt::format("{}: {}", row.where, reason));
}

/// The rows of numbers of a text; # and % begin comments.
std::vector<Row> ReadRows(std::string_view text, const std::string& file) {
  std::vector<Row> rows;
  core::TextLines lines(text);
  while (auto line = lines.Next()) {
    const auto words = core::SplitWords(line->substr(0, line->find_first_of("#%")), ",;");
    if (words.empty()) continue;
    Row row{fmt::format("{}:{}", file, lines.number()), {}};
    for (size_t k = 0; k < words.size(); ++k) {
      const auto value = core::ParseNumber<double>(words[k]);
      if (!value) Fail(row, fmt::format("value {}: '{}' is no number", k + 1, words[k].substr(0, 40)));
      if (!std::isfinite(*value)) Fail(row, fmt::format("value {}: {} is not finite", k + 1, *value));
      row.value.push_back(*value);
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw InputError(fmt::format("{}: holds no poses", file));
  return rows;
}

Vec3 CheckedPosition(const Row& row, double x, double y, double z) {
  const Vec3 p(x, y, z);
  if (p.norm() > kFarthest_m)
    Fail(row, fmt::format("position is {:g} m from the origin (limit {:g})", p.norm(), kFarthest_m));
  return p;
}

/// tx ty tz qx qy qz qw from value `first` on.
Pose PoseFromQuaternion(const Row& row, size_t first) {
  const double* v = row.value.data() + first;
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionTolerance)) {
    Fail(row, fmt::format("length of the quaternion (qx qy qz qw) is {:g} (1 within {})", q.norm(),
                          kQuaternionTolerance));
  }
  return core::MakePose(q.normalized().toRotationMatrix(), CheckedPosition(row, v[0], v[1], v[2]));
}

/// The upper 3 x 4 of a homogeneous matrix, row after row.
Pose PoseFromMatrix(const Row& row, const double* v) {
  Mat3 R;
  R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  const double error = (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kRotationTolerance) || !(R.determinant() > 0.0)) {
    Fail(row, fmt::format("not a rotation: R R^T differs from identity by {:g} (limit {}), determinant {:g}",
                          error, kRotationTolerance, R.determinant()));
  }
  return core::MakePose(Eigen::Quaterniond(R).normalized().toRotationMatrix(),
                        CheckedPosition(row, v[3], v[7], v[11]));
}

void CheckWidth(const Row& row, size_t width) {
  if (row.value.size() != width)
    Fail(row, fmt::format("{} numbers, {} in the first row", row.value.size(), width));
}

RecordedPoses PosesFromTum(const std::vector<Row>& rows) {
  RecordedPoses poses;
  for (const Row& row : rows) {
    CheckWidth(row, 8);
    if (poses.timed() && row.value[0] < poses.time_s.back()) {
      Fail(row, fmt::format("time {:.9f} comes after {:.9f}: times must ascend", row.value[0],
                            poses.time_s.back()));
    }
    poses.T_map_lidar.push_back(PoseFromQuaternion(row, 1));
    poses.time_s.push_back(row.value[0]);
  }
  return poses;
}

RecordedPoses PosesFromKitti(const std::vector<Row>& rows) {
  RecordedPoses poses;
  for (const Row& row : rows) {
    CheckWidth(row, 12);
    poses.T_map_lidar.push_back(PoseFromMatrix(row, row.value.data()));
  }
  return poses;
}

RecordedPoses PosesFromMatrices(const std::vector<Row>& rows) {
  RecordedPoses poses;
  std::array<double, 16> v;
  for (size_t i = 0; i < rows.size(); ++i) {
    CheckWidth(rows[i], 4);
    std::copy(rows[i].value.begin(), rows[i].value.end(), v.begin() + static_cast<long>(4 * (i % 4)));
    if (i % 4 != 3) continue;
    if (v[12] != 0.0 || v[13] != 0.0 || v[14] != 0.0 || v[15] != 1.0)
      Fail(rows[i], "the last row of a 4 x 4 pose is not 0 0 0 1");
    poses.T_map_lidar.push_back(PoseFromMatrix(rows[i - 3], v.data()));
  }
  if (rows.size() % 4 != 0) Fail(rows.back(), "ends within a 4 x 4 matrix");
  return poses;
}

}  // namespace

RecordedPoses ParsePoses(std::string_view text, const std::string& file) {
  const std::vector<Row> rows = ReadRows(text, file);
  switch (rows.front().value.size()) {
    case 8:
      return PosesFromTum(rows);
    case 12:
      return PosesFromKitti(rows);
    case 4:
      return PosesFromMatrices(rows);
    default:
      Fail(rows.front(), fmt::format("{} numbers in a row (TUM has 8, KITTI 12, a 4 x 4 matrix 4)",
                                     rows.front().value.size()));
  }
}

RecordedPoses ReadPoses(const std::filesystem::path& path) {
  return ParsePoses(core::ReadFile(path), path.string());
}

Calibration ParseCalibration(std::string_view text, const std::string& file) {
  Calibration calibration;
  core::TextLines lines(text);
  while (const auto line = lines.Next()) {
    if (!line->starts_with("Tr:") && !line->starts_with("Tr_velo_to_cam:")) continue;
    std::vector<Row> rows = ReadRows(line->substr(line->find(':') + 1), file);
    rows.front().where = fmt::format("{}:{}", file, lines.number());
    if (rows.front().value.size() != 12)
      Fail(rows.front(), fmt::format("Tr has {} numbers (12)", rows.front().value.size()));
    calibration.T_posed_lidar = PoseFromMatrix(rows.front(), rows.front().value.data());
    calibration.is_kitti = true;
    return calibration;
  }
  const std::vector<Row> rows = ReadRows(text, file);
  if (rows.size() == 1 && rows.front().value.size() == 7) {
    calibration.T_posed_lidar = PoseFromQuaternion(rows.front(), 0);
    return calibration;
  }
  const RecordedPoses poses = ParsePoses(text, file);
  if (poses.timed() || poses.size() != 1)
    Fail(rows.front(), "a calibration is one pose: 7 numbers tx ty tz qx qy qz qw, 12, or 4 x 4");
  calibration.T_posed_lidar = poses.T_map_lidar.front();
  return calibration;
}

Calibration ReadCalibration(const std::filesystem::path& path) {
  return ParseCalibration(core::ReadFile(path), path.string());
}

void Apply(const Calibration& calibration, RecordedPoses* poses) {
  const Pose before = calibration.is_kitti ? calibration.T_posed_lidar.inverse() : Pose::Identity();
  for (Pose& T : poses->T_map_lidar) T = before * T * calibration.T_posed_lidar;
}

std::optional<Pose> PoseNear(const RecordedPoses& poses, double time_s, double max_dt_s) {
  const auto after = std::lower_bound(poses.time_s.begin(), poses.time_s.end(), time_s);
  const auto right = static_cast<size_t>(after - poses.time_s.begin());
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double since = right > 0 ? time_s - poses.time_s[right - 1] : kNever;
  const double until = right < poses.size() ? poses.time_s[right] - time_s : kNever;
  if (since <= max_dt_s && until <= max_dt_s)
    return core::Interpolate(poses.T_map_lidar[right - 1], poses.T_map_lidar[right], since / (since + until));
  if (until <= max_dt_s && until <= since) return poses.T_map_lidar[right];
  if (since <= max_dt_s) return poses.T_map_lidar[right - 1];
  return std::nullopt;
}

void WriteTum(const std::filesystem::path& path, const std::vector<core::StampedPose>& poses) {
  std::string out = "# time tx ty tz qx qy qz qw\n";
  for (const core::StampedPose& pose : poses) {
    const Eigen::Quaterniond q(pose.T.linear());
    const Vec3 t = pose.T.translation();
    out += fmt::format("{:.9f} {:.9g} {:.9g} {:.9g} {:.12g} {:.12g} {:.12g} {:.12g}\n", pose.time_s, t.x(),
                       t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  core::WriteFileAtomically(path, out);
}

}  // namespace atlas::mapping
