// Tables of numbers that people may have edited: each wrong value is told by file, line and column.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/errors.h"
#include "core/files.h"
#include "core/geometry.h"
#include "core/text_lines.h"

namespace atlas::core {

/// Columns of a pose, which CsvOfPose fills.
constexpr const char* kCsvPoseHead = "x_m,y_m,z_m,qx,qy,qz,qw";
std::string CsvOfPose(const Pose& T);

/// A table's rows, value by value, read in order of the columns. Every call throws InputError (one line:
/// file, line, column, value, limits) where the table is not as expected.
class CsvTable {
 public:
  CsvTable(const std::filesystem::path& path, const std::string& head)
      : path_(path), head_(head), text_(ReadFile(path)), lines_(text_), columns_(SplitCells(head_)) {
    const auto first = lines_.Next();
    if (!first || *first != head) Fail(fmt::format("does not begin with {}", head));
  }

  bool NextRow() {
    const auto line = lines_.Next();
    if (!line) return false;
    cells_ = SplitCells(*line);
    at_ = 0;
    if (cells_.size() != columns_.size())
      Fail(fmt::format("line {}: {} values, must be {}", lines_.number(), cells_.size(), columns_.size()));
    return true;
  }
  template <typename T>
  T Number(T least, T most) {
    const std::string_view cell = cells_[at_];
    const auto value = ParseNumber<T>(cell);
    if (!value || !(*value >= least && *value <= most)) {
      Fail(
          fmt::format("line {}: {} {}, must be {} to {}", lines_.number(), columns_[at_], cell, least, most));
    }
    ++at_;
    return *value;
  }
  /// Metres, within 1e7 of the origin.
  double Coordinate() { return Number<double>(-1e7, 1e7); }
  Vec3 Point() {
    const double x = Coordinate(), y = Coordinate();
    return {x, y, Coordinate()};
  }
  Pose NextPose() {
    const Vec3 p = Point();
    double q[4];
    for (double& part : q) part = Number<double>(-1.0, 1.0);
    const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
    if (std::abs(turn.norm() - 1.0) > 1e-6)
      Fail(fmt::format("line {}: quaternion of length {}, must be 1", lines_.number(), turn.norm()));
    return MakePose(turn.normalized().toRotationMatrix(), p);
  }
  std::string_view Word() { return cells_[at_++]; }
  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", path_.string(), reason));
  }
  const std::filesystem::path& path() const { return path_; }
  size_t line() const { return lines_.number(); }

 private:
  static std::vector<std::string_view> SplitCells(std::string_view line) {
    std::vector<std::string_view> cells;
    for (size_t begin = 0; begin <= line.size();) {
      const size_t end = std::min(line.find(',', begin), line.size());
      cells.push_back(line.substr(begin, end - begin));
      begin = end + 1;
    }
    return cells;
  }

  std::filesystem::path path_;
  std::string head_, text_;
  TextLines lines_;
  std::vector<std::string_view> columns_, cells_;
  size_t at_ = 0;
};

}  // namespace atlas::core
