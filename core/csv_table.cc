#include "core/csv_table.h"

namespace atlas::core {

std::string CsvOfPose(const Pose& T) {
  const Vec3& p = T.translation();
  const Eigen::Quaterniond q(T.linear());
  return fmt::format("{:.9f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f},{:.12f}", p.x(), p.y(), p.z(), q.x(),
                     q.y(), q.z(), q.w());
}

}  // namespace atlas::core
