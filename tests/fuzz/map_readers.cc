#include <filesystem>

#include "core/files.h"
#include "mapping/io/map_codec.h"
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

/// What lies behind the checksums: chunks as frames unpack to.
template <typename Field>
FuzzedReader ChunkReader(const std::string& name, typename Field::Value value) {
  mapping::Octree<Field> map(0.1);
  for (int i = 0; i < 40; ++i) map.Set({i * 3 - 60, i % 7, i - 5}, value);
  std::string chunks;
  for (const auto* chunk : map.Chunks()) mapping::AppendChunk(map, *chunk, &chunks);
  return {name, {chunks}, [](std::string_view bytes, const std::filesystem::path& file) {
            core::ByteReader reader(bytes, file.string());
            mapping::Octree<Field> read(0.1);
            for (uint64_t code = 0; reader.remaining() > 0;) mapping::ReadChunk(&reader, &code, &read);
          }};
}

}  // namespace

std::vector<FuzzedReader> MapReaders() {
  FuzzedReader map{"map.atlas",
                   {SmallMap<mapping::OccupancyField>(20), SmallMap<mapping::TsdfField>({1000, 7})},
                   [](auto bytes, auto& file) { mapping::ParseMap(bytes, file.string()); }};
  map.detects_every_change = true;
  return {map, ChunkReader<mapping::OccupancyField>("occupancy.chunk", 20),
          ChunkReader<mapping::TsdfField>("tsdf.chunk", {1000, 7})};
}

}  // namespace atlas::fuzz
