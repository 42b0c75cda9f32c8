// The map on disk: `map.atlas`, and exports to OctoMap and PLY.
//
// map.atlas: magic "SEATLAS\n", format version, field, resolution, bounds, counts, then zstd frames of chunks
// by ascending Morton code, each with a checksum, and one of the whole. Written whole or not at all. The
// bytes depend on the map alone, not on how threads came to build it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <variant>

#include "core/mesh.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

constexpr uint32_t kMapFileVersion = 1;

/// @throws InputError when the file cannot be written.
template <typename Field>
void WriteMap(const std::filesystem::path& path, const Octree<Field>& map);

using AnyOctree = std::variant<OccupancyOctree, TsdfOctree>;
/// @throws InputError (one line: file, field, value, limit) for a wrong magic, a future version, a flipped
/// bit or a truncated file. Summaries are current.
AnyOctree ReadMap(const std::filesystem::path& path);
/// The same of a file's content; `file` is the name used in errors.
AnyOctree ParseMap(std::string_view bytes, const std::string& file);
/// Whether the file begins as a map file does.
bool IsMapFile(const std::filesystem::path& path);

/// OctoMap's .bt (maximum likelihood) or .ot (log-odds), by the extension: written as a stream, nodes of one
/// value pruned, so that memory does not grow with the map. Signed distances are written as their sign.
/// @throws InputError for another extension, an empty map or one beyond OctoMap's 2^16 voxels a side.
template <typename Field>
void ExportOctomap(const std::filesystem::path& path, const Octree<Field>& map);

/// Centres of occupied voxels (occupancy), or of voxels within one of the surface (TSDF).
template <typename Field>
core::PointCloud SurfaceVoxels(const Octree<Field>& map);

}  // namespace atlas::mapping
