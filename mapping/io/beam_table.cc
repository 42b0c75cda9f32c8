#include "mapping/io/beam_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "mapping/io/beam_fit.h"

namespace atlas::mapping {
namespace {

using core::InputError;
using core::WrapAngle;
using Json = nlohmann::json;

constexpr double kTableLimit_rad = core::Radians(1.0);
constexpr double kOffsetLimit_rad = core::Radians(0.3);
constexpr size_t kMostBeams = 4096;

double WorstRow(const MeasuredRows& measured, const std::vector<double>& table, size_t* row) {
  double worst = -1.0;
  for (size_t r = 0; r < table.size(); ++r) {
    const double error = std::abs(measured.elevation_rad[r] - table[r]);
    if (!measured.measured[r] || error <= worst) continue;
    worst = error;
    *row = r;
  }
  return worst;
}

/// The table in the order of the scan's rows.
core::LidarModel InOrderOf(const MeasuredRows& measured, const core::LidarModel& table,
                           const std::string& what) {
  core::LidarModel flipped = table;
  std::reverse(flipped.elevation_rad.begin(), flipped.elevation_rad.end());
  std::reverse(flipped.azimuth_offset_rad.begin(), flipped.azimuth_offset_rad.end());
  size_t row = 0, flipped_row = 0;
  const double worst = WorstRow(measured, table.elevation_rad, &row);
  if (worst <= kTableLimit_rad) return table;
  if (WorstRow(measured, flipped.elevation_rad, &flipped_row) <= kTableLimit_rad) return flipped;
  throw InputError(
      fmt::format("{}: row {} points {:.2f} deg up, {:.2f} in the table of {} (limit {} deg apart)", what,
                  row, core::Degrees(measured.elevation_rad[row]), core::Degrees(table.elevation_rad[row]),
                  table.name, core::Degrees(kTableLimit_rad)));
}

/// How far the measured rows are from these offsets, after the common phase.
double OffsetError(const MeasuredRows& measured, const std::vector<double>& offset) {
  const double phase = CommonPhase(measured, offset);
  double sum = 0.0;
  int rows = 0;
  for (size_t r = 0; r < offset.size(); ++r) {
    if (!measured.measured[r]) continue;
    sum += std::abs(WrapAngle(measured.phase_rad[r] - offset[r] - phase));
    ++rows;
  }
  return sum / rows;
}

/// The offsets that are left once rows have been shifted by whole columns.
std::vector<double> Destaggered(std::vector<double> offset, double step) {
  for (double& o : offset) o -= std::round(o / step) * step;
  return offset;
}

std::vector<double> Angles(const Json& root, const char* key, const std::string& file) {
  const Json* holder = &root;
  if (!root.contains(key) && root.contains("beam_intrinsics")) holder = &root["beam_intrinsics"];
  if (!holder->is_object() || !holder->contains(key) || !(*holder)[key].is_array())
    throw InputError(fmt::format("{}: no list '{}'", file, key));
  std::vector<double> angles;
  for (const Json& value : (*holder)[key]) {
    const double degrees = value.is_number() ? value.get<double>() : std::nan("");
    if (!(std::abs(degrees) <= 180.0))
      throw InputError(
          fmt::format("{}: {}[{}] is no angle in degrees (-180 to 180)", file, key, angles.size()));
    angles.push_back(core::Radians(degrees));
  }
  if (angles.size() < 2 || angles.size() > kMostBeams)
    throw InputError(fmt::format("{}: {} has {} angles (2 to {})", file, key, angles.size(), kMostBeams));
  return angles;
}

}  // namespace

BeamFit FitBeams(const core::LidarModel& table, const std::vector<RecordedCloud>& clouds,
                 const std::string& what) {
  BeamFit fit = EstimateBeams(clouds, what);
  if (fit.model.rows() != table.rows())
    throw InputError(
        fmt::format("{}: {} rows, {} in the table of {}", what, fit.model.rows(), table.rows(), table.name));
  const std::vector<HitAngles> scans = AnglesOf(clouds);
  const double step = fit.model.column_step_rad;
  const MeasuredRows measured = MeasureRows(scans, table.rows(), clouds[0].columns, step);
  core::LidarModel model = InOrderOf(measured, table, what);
  const std::vector<double> destaggered = Destaggered(model.azimuth_offset_rad, step);
  const double as_fired = OffsetError(measured, model.azimuth_offset_rad);
  const double as_image = OffsetError(measured, destaggered);
  if (as_image < as_fired) model.azimuth_offset_rad = destaggered;
  if (std::min(as_image, as_fired) > kOffsetLimit_rad)
    model.azimuth_offset_rad = fit.model.azimuth_offset_rad;
  model.columns = fit.model.columns;
  model.column_step_rad = step;
  model.first_azimuth_rad = CommonPhase(measured, model.azimuth_offset_rad);
  fit.model = model;
  MeasureResiduals(scans, &fit);
  return fit;
}

core::LidarModel ParseOusterMetadata(std::string_view text, const std::string& file) {
  const Json root = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!root.is_object()) throw InputError(fmt::format("{}: no JSON object", file));
  core::LidarModel model;
  model.name = std::filesystem::path(file).filename().string();
  model.elevation_rad = Angles(root, "beam_altitude_angles", file);
  model.azimuth_offset_rad = Angles(root, "beam_azimuth_angles", file);
  if (model.azimuth_offset_rad.size() != model.elevation_rad.size()) {
    throw InputError(fmt::format("{}: {} beam_azimuth_angles for {} beam_altitude_angles", file,
                                 model.azimuth_offset_rad.size(), model.elevation_rad.size()));
  }
  for (double& offset : model.azimuth_offset_rad) offset = -offset;  // theirs turn clockwise
  model.columns = 1024;
  return model;
}

core::LidarModel ReadOusterMetadata(const std::filesystem::path& path) {
  return ParseOusterMetadata(core::ReadFile(path), path.string());
}

}  // namespace atlas::mapping
