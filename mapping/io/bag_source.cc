#include "mapping/io/bag_source.h"

#include <fmt/format.h>

#include "core/errors.h"

namespace atlas::mapping {

bool HasBagSupport() {
  return false;
}

std::unique_ptr<ScanSource> OpenBag(const std::filesystem::path& file, const std::string&) {
  throw core::InputError(fmt::format(
      "{}: this build does not read ROS bags; convert it to PCD files and TUM poses", file.string()));
}

RecordedPoses ReadBagPoses(const std::filesystem::path& file, const std::string&) {
  throw core::InputError(fmt::format(
      "{}: this build does not read ROS bags; convert it to PCD files and TUM poses", file.string()));
}

}  // namespace atlas::mapping
