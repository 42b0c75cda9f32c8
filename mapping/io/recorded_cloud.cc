#include "mapping/io/recorded_cloud.h"

#include <fmt/format.h>

#include "core/errors.h"
#include "core/files.h"

namespace atlas::mapping {
namespace {

std::string Ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

}  // namespace

bool HasCloudExtension(const std::filesystem::path& path) {
  const std::string ending = Ending(path);
  return ending == ".pcd" || ending == ".ply" || ending == ".bin";
}

RecordedCloud ReadCloud(const std::filesystem::path& path) {
  const std::string ending = Ending(path), file = path.string();
  if (!HasCloudExtension(path))
    throw core::InputError(
        fmt::format("{}: '{}' is not a cloud format read here (.pcd, .ply, .bin)", file, ending));
  const std::string bytes = core::ReadFile(path);
  if (bytes.empty()) throw core::InputError(fmt::format("{}: the file is empty", file));
  if (ending == ".ply") return ParsePlyCloud(bytes, file);
  if (ending == ".pcd") return ParsePcd(bytes, file);
  return ParseKittiBin(bytes, file);
}

}  // namespace atlas::mapping
