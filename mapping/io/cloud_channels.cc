#include "mapping/io/cloud_channels.h"

#include <fmt/format.h>

#include <cassert>

#include "core/errors.h"

namespace atlas::mapping {
namespace {

using core::InputError;
using core::ReturnKind;
using core::Vec3f;

constexpr double kFarthestPoint_m = 1e5;
/// A scan lasts less than this, and begins less than this from its stamp.
constexpr double kLongestScan_s = 2.0;

/// The largest unit (s, ms, us, ns) in which `span` is the length of a scan.
double UnitOf(double span) {
  double unit = 1.0;
  while (unit > 1e-9 && span * unit > kLongestScan_s) unit *= 1e-3;
  return unit;
}

/// Times after the stamp, in seconds; nothing where the file's are too coarse to tell points apart.
void SetTimes(const RawCloud& raw, RecordedCloud* cloud, const std::string& file) {
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (size_t i = 0; i < raw.time.size(); ++i) {
    if (!std::isfinite(raw.time[i])) {
      if (cloud->p_lidar[i].allFinite())
        throw InputError(fmt::format("{}: point {}: time is not finite", file, i));
      continue;
    }
    first = std::min(first, raw.time[i]);
    last = std::max(last, raw.time[i]);
  }
  if (!(first <= last)) return;
  const double unit = UnitOf(last - first);
  if ((last - first) * unit > kLongestScan_s) {
    throw InputError(fmt::format("{}: times from {} to {} span more than {} s even as nanoseconds", file,
                                 first, last, kLongestScan_s));
  }
  const bool absolute = std::abs(first) * unit > kLongestScan_s;
  if (absolute && raw.time_is_single && std::abs(first) * unit > 1e4) return;
  if (absolute) cloud->stamp_s = first * unit;
  cloud->time_s.resize(raw.time.size());
  for (size_t i = 0; i < raw.time.size(); ++i) {
    const double t = std::isfinite(raw.time[i]) ? raw.time[i] - (absolute ? first : 0.0) : 0.0;
    cloud->time_s[i] = static_cast<float>(t * unit);
  }
}

void SetKinds(const RawCloud& raw, RecordedCloud* cloud, const std::string& file) {
  cloud->kind.resize(raw.kind.size());
  for (size_t i = 0; i < raw.kind.size(); ++i) {
    const double kind = raw.kind[i];
    if (kind != 0.0 && kind != 1.0 && kind != 2.0) {
      throw InputError(fmt::format("{}: point {}: kind is {} (0 hit, 1 void or 2 dropout)", file, i, kind));
    }
    cloud->kind[i] = static_cast<ReturnKind>(kind);
    if (cloud->kind[i] == ReturnKind::kHit && !cloud->p_lidar[i].allFinite())
      cloud->kind[i] = ReturnKind::kDropout;
  }
}

void SetRings(const RawCloud& raw, RecordedCloud* cloud, const std::string& file) {
  cloud->ring.resize(raw.ring.size());
  for (size_t i = 0; i < raw.ring.size(); ++i) {
    const double ring = raw.ring[i];
    if (!(ring >= 0.0 && ring <= 65535.0) || ring != std::floor(ring)) {
      if (cloud->p_lidar[i].allFinite())
        throw InputError(fmt::format("{}: point {}: ring is {} (0 to 65535)", file, i, ring));
      continue;
    }
    cloud->ring[i] = static_cast<uint16_t>(ring);
  }
}

}  // namespace

float ToFloat(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (std::abs(value) > kLargest) return std::copysign(std::numeric_limits<float>::infinity(), value);
  return static_cast<float>(value);
}

std::optional<Channel> ChannelOf(std::string_view field) {
  std::string name(field);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name.starts_with("scalar_")) name.erase(0, 7);
  if (name == "x") return kX;
  if (name == "y") return kY;
  if (name == "z") return kZ;
  if (name == "ring") return kRing;
  if (name == "kind") return kKind;
  for (const char* time : {"t", "time", "time_s", "time_stamp", "timestamp", "offset_time"}) {
    if (name == time) return kTime;
  }
  return std::nullopt;
}

void RawCloud::Resize(size_t points, const bool (&has)[kChannels]) {
  p.resize(points);
  if (has[kTime]) time.resize(points);
  if (has[kRing]) ring.resize(points);
  if (has[kKind]) kind.resize(points);
}

void RawCloud::Set(Channel channel, size_t i, double value) {
  switch (channel) {
    case kX:
    case kY:
    case kZ:
      p[i][channel] = ToFloat(value);
      break;
    case kTime:
      time[i] = value;
      break;
    case kRing:
      ring[i] = value;
      break;
    case kKind:
      kind[i] = value;
      break;
    case kChannels:
      break;
  }
}

RecordedCloud FinishCloud(RawCloud raw, int rows, int columns, bool organised, const std::string& file) {
  assert(raw.p.size() == static_cast<size_t>(rows) * static_cast<size_t>(columns));
  RecordedCloud cloud;
  cloud.rows = rows;
  cloud.columns = columns;
  cloud.organised = organised;
  cloud.p_lidar = std::move(raw.p);
  for (size_t i = 0; i < cloud.p_lidar.size(); ++i) {
    Vec3f& p = cloud.p_lidar[i];
    if (!p.allFinite() || p.isZero(0.0f)) {
      p.setConstant(std::numeric_limits<float>::quiet_NaN());
    } else if (p.cast<double>().norm() > kFarthestPoint_m) {
      throw InputError(fmt::format("{}: point {}: {:g} m from the sensor (limit {:g} m)", file, i,
                                   p.cast<double>().norm(), kFarthestPoint_m));
    }
  }
  SetTimes(raw, &cloud, file);
  SetKinds(raw, &cloud, file);
  SetRings(raw, &cloud, file);
  return cloud;
}

}  // namespace atlas::mapping
