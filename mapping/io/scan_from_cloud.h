// From a recorded cloud to the scan a sensor would have emitted.
#pragma once

#include <optional>

#include "mapping/io/beam_table.h"
#include "mapping/io/recorded_cloud.h"

namespace atlas::mapping {

struct ScanRules {
  core::ReturnKind no_return = core::ReturnKind::kDropout;  ///< where the cloud does not tell
  double min_range_m = 0.0;                                 ///< nearer: dropout
  double max_range_m = 0.0;                                 ///< farther: void; 0: no limit
};

/// Organised along `model` (rows x columns, no-return pixels along their beams; @pre of the cloud's shape);
/// unorganised without one (rows = 0, returns only). stamp_s stays 0.
core::LidarScan ScanFromCloud(const RecordedCloud& cloud, const core::LidarModel* model,
                              const ScanRules& rules);

/// Rows for columns: some drivers write a firing a row.
RecordedCloud Transposed(const RecordedCloud& cloud);

}  // namespace atlas::mapping
