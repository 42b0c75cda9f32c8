#include "core/lidar_model.h"

#include "core/errors.h"

namespace atlas::core {
namespace {

std::vector<double> Evenly(int rows, double top_deg, double bottom_deg) {
  std::vector<double> elevation(static_cast<size_t>(rows));
  for (int i = 0; i < rows; ++i) {
    elevation[static_cast<size_t>(i)] = Radians(top_deg + (bottom_deg - top_deg) * i / (rows - 1));
  }
  return elevation;
}

/// Four beams of an Ouster fire side by side: the azimuth offset repeats every four rows.
std::vector<double> OusterOffsets(int rows, double step_deg) {
  std::vector<double> offset(static_cast<size_t>(rows));
  for (int i = 0; i < rows; ++i) offset[static_cast<size_t>(i)] = Radians(step_deg * (1.5 - i % 4));
  return offset;
}

LidarModel Vlp16() {
  LidarModel m;
  m.name = "vlp16";
  m.elevation_rad = Evenly(16, 15.0, -15.0);
  m.azimuth_offset_rad.assign(16, 0.0);
  m.columns = 1800;
  m.min_range_m = 0.4;
  m.max_range_m = 100.0;
  m.range_sigma_m = 0.01;
  m.dropout_probability = 0.002;
  return m;
}

LidarModel Os1() {
  LidarModel m;
  m.name = "os1_64";
  m.elevation_rad = Evenly(64, 16.6, -16.6);
  m.azimuth_offset_rad = OusterOffsets(64, 2.1);
  m.columns = 1024;
  m.min_range_m = 0.5;
  m.max_range_m = 120.0;
  m.range_sigma_m = 0.012;
  m.dropout_probability = 0.002;
  return m;
}

LidarModel Os0() {
  LidarModel m = Os1();
  m.name = "os0_64";
  m.elevation_rad = Evenly(64, 45.0, -45.0);
  m.max_range_m = 50.0;
  return m;
}

}  // namespace

double LidarModel::StepRad() const {
  return column_step_rad != 0.0 ? column_step_rad : -2.0 * kPi / columns;
}

double LidarModel::AzimuthRad(int row, int column) const {
  return first_azimuth_rad + StepRad() * column + azimuth_offset_rad[static_cast<size_t>(row)];
}

Vec3 LidarModel::Direction(int row, int column) const {
  const double azimuth = AzimuthRad(row, column), elevation = elevation_rad[static_cast<size_t>(row)];
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

std::vector<std::string> LidarModelNames() {
  return {"vlp16", "os1_64", "os0_64"};
}

LidarModel FindLidarModel(const std::string& name) {
  if (name == "vlp16") return Vlp16();
  if (name == "os1_64") return Os1();
  if (name == "os0_64") return Os0();
  throw InputError(UnknownName("LiDAR model", name, LidarModelNames()));
}

}  // namespace atlas::core
