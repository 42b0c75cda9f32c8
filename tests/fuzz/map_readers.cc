#include <filesystem>

#include "core/files.h"
#include "mapping/io/map_file.h"
#include "tests/fuzz/fuzzed_reader.h"

namespace atlas::fuzz {
namespace {

template <typename Field>
std::string SmallMap(typename Field::Value value) {
  mapping::Octree<Field> map(0.1);
  for (int i = 0; i < 40; ++i) map.Set({i * 3 - 60, i % 7, i - 5}, value);
  const auto path = std::filesystem::temp_directory_path() / "atlas_fuzz_seed" / "map.atlas";
  mapping::WriteMap(path, map);
  const std::string bytes = core::ReadFile(path);
  std::filesystem::remove_all(path.parent_path());
  return bytes;
}

}  // namespace

std::vector<FuzzedReader> MapReaders() {
  FuzzedReader map{"map.atlas",
                   {SmallMap<mapping::OccupancyField>(20), SmallMap<mapping::TsdfField>({1000, 7})},
                   [](auto bytes, auto& file) { mapping::ParseMap(bytes, file.string()); }};
  map.detects_every_change = true;
  return {map};
}

}  // namespace atlas::fuzz
