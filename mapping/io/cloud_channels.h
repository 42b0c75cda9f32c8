// What the readers of clouds share: which field is which channel, and the checks of a finished cloud.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/io/recorded_cloud.h"

namespace atlas::mapping {

enum Channel { kX, kY, kZ, kTime, kRing, kKind, kChannels };

/// The channel that a field of this name holds (any case, with or without CloudCompare's "scalar_").
std::optional<Channel> ChannelOf(std::string_view field);

/// The numbers of a file, point by point, before their meaning is known.
struct RawCloud {
  std::vector<core::Vec3f> p;
  std::vector<double> time, ring, kind;  ///< a point each, or empty
  bool time_is_single = false;           ///< float32: too coarse for times since 1970

  void Set(Channel channel, size_t i, double value);
  /// Makes room for the channels that `has` names.
  void Resize(size_t points, const bool (&has)[kChannels]);
};

/// Points, times from the stamp, rings and kinds. @throws InputError "FILE: point 7: ..." for a point farther
/// than 100 km, a kind other than 0 to 2 or a ring that is none.
RecordedCloud FinishCloud(RawCloud raw, int rows, int columns, bool organised, const std::string& file);

/// A coordinate or time as float, where double to float does not overflow.
float ToFloat(double value);

}  // namespace atlas::mapping
