// An atlas on disk: one folder, which opens again as a map.
//
//     atlas.csv         format, size of a voxel, what counts as free and occupied, the box that is kept
//     submaps.csv       a submap a row, by precedence: root keyframe, pose, file
//     keyframes.csv     a keyframe a row: its submap, its pose, where the sensor was
//     clouds.csv        an accumulated cloud a row: its submap, pose in it, file
//     submap_003.atlas  the octree, of occupancy or of signed distances (map_file.h)
//     cloud_003_0.ply   the points
//     files.csv         size and CRC-64 of each of these, written last: what is not whole is found out
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "mapping/atlas/atlas_view.h"
#include "mapping/atlas/submap.h"
#include "mapping/meshing/marching_cubes.h"

namespace atlas::mapping {

constexpr uint32_t kAtlasFormat = 1;

struct SavedSubmap {
  uint32_t id = 0;
  core::KeyframeId root = 0;
  double overlap = 0.0;  ///< as of Submap
  core::Pose T_map_submap = core::Pose::Identity();
  std::vector<HeldKeyframe> keyframes;
  struct Cloud {
    core::Pose T_submap_cloud = core::Pose::Identity();
    std::vector<core::Vec3f> points;
  };
  std::vector<Cloud> clouds;
  std::shared_ptr<const StoredContents> contents;
};

struct SavedAtlas {
  double resolution_m = 0.0;
  StateLogOdds states;
  core::Box3 keep_map;
  std::vector<SavedSubmap> submaps;  ///< by precedence: the first is right

  std::shared_ptr<const AtlasView> View() const;
};

/// What an atlas holds at this moment, to be saved.
SavedAtlas ToSave(const std::vector<const Submap*>& by_precedence, double resolution_m,
                  const StateLogOdds& states, const core::Box3& keep_map);

/// @throws InputError when a file cannot be written.
void WriteAtlas(const std::filesystem::path& folder, const SavedAtlas& atlas);
/// @throws InputError (one line: file, field, value, limit) where a file is missing, damaged or of a later
/// format.
SavedAtlas LoadAtlas(const std::filesystem::path& folder);
/// Of its voxels, m. @throws InputError where its head is damaged.
double ResolutionOfAtlas(const std::filesystem::path& folder);
/// Whether the path is a folder that holds files.csv and submaps.csv, or one of the two.
bool IsAtlasFolder(const std::filesystem::path& path);
/// Whether a file of that name belongs to a saved atlas.
bool IsAtlasFile(const std::string& name);

/// One mesh in the map frame: of each submap the triangles whose middle no newer one has measured.
core::TriMesh ExtractMesh(const AtlasView& view, const MeshOptions& options);
core::TriMesh ExtractMesh(const SavedAtlas& atlas, const MeshOptions& options);
/// Centres of what is occupied, in the map frame; where submaps overlap, the newest is right.
core::PointCloud SurfaceVoxels(const SavedAtlas& atlas);
/// All submaps on one lattice, that of the map frame; where they overlap, the newest is right.
OccupancyOctree OnOneLattice(const SavedAtlas& atlas);

}  // namespace atlas::mapping
