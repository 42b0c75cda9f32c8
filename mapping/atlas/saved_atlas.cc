#include "mapping/atlas/saved_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "core/checked_folder.h"
#include "core/csv_table.h"
#include "core/errors.h"
#include "mapping/atlas/distance_states.h"
#include "mapping/io/map_file.h"
#include "mapping/io/recorded_cloud.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::Pose;
using core::Vec3;

constexpr const char* kAtlasHead =
    "format,resolution_m,free_log_odds,occupied_log_odds,keep_min_x_m,keep_min_y_m,"
    "keep_min_z_m,keep_max_x_m,keep_max_y_m,keep_max_z_m";
constexpr const char* kSubmapHead = "submap,root_keyframe,keyframes,overlap,file,";
constexpr const char* kKeyframeHead = "keyframe,submap,sensor_x_m,sensor_y_m,sensor_z_m,";
constexpr const char* kCloudHead = "submap,file,";

/// A file of the folder itself.
fs::path FileOf(core::CsvTable* table, const std::string& prefix) {
  const std::string_view name = table->Word();
  if (!name.starts_with(prefix) || !IsAtlasFile(std::string(name)))
    table->Fail(fmt::format("line {}: file {}, must be {}...", table->line(), name, prefix));
  return table->path().parent_path() / name;
}

std::string SubmapFile(uint32_t id) {
  return fmt::format("submap_{:03d}.atlas", id);
}

std::shared_ptr<const StoredContents> ReadSubmap(const fs::path& file, double resolution_m) {
  AnyOctree map = ReadMap(file);
  const double held_m = std::visit([](const auto& tree) { return tree.resolution_m(); }, map);
  if (held_m != resolution_m)
    throw core::InputError(
        fmt::format("{}: resolution {} m, must be {}", file.string(), held_m, resolution_m));
  OctreeContents contents{OccupancyOctree(resolution_m), {}, {}};
  if (auto* const distances = std::get_if<TsdfOctree>(&map)) {
    contents.tree = StatesOf(*distances);
    contents.distances.emplace(std::move(*distances));
  } else {
    contents.tree = std::move(std::get<OccupancyOctree>(map));
  }
  return std::make_shared<const StoredContents>(std::make_shared<ContentsPager>(0), std::move(contents));
}

void LoadHead(const fs::path& folder, SavedAtlas* atlas) {
  core::CsvTable table(folder / "atlas.csv", kAtlasHead);
  if (!table.NextRow()) table.Fail("ends early");
  table.Number<uint32_t>(1, kAtlasFormat);
  atlas->resolution_m = table.Number<double>(0.001, 10.0);
  atlas->states.free = table.Number<double>(-100.0, 100.0);
  atlas->states.occupied = table.Number<double>(-100.0, 100.0);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (core::Vec3* corner : {&atlas->keep_map.min, &atlas->keep_map.max}) {
    for (int axis = 0; axis < 3; ++axis) (*corner)[axis] = table.Number<double>(-kInfinity, kInfinity);
  }
}

/// Of submaps and keyframes.
constexpr uint32_t kMost = 1u << 30;

using Places = std::map<uint32_t, size_t>;  ///< of submaps in the atlas, by their numbers

SavedSubmap& NextSubmap(core::CsvTable* table, const Places& places, SavedAtlas* atlas) {
  const auto found = places.find(table->Number<uint32_t>(0, kMost));
  if (found == places.end())
    table->Fail(fmt::format("line {}: of a submap that is not there", table->line()));
  return atlas->submaps[found->second];
}

void LoadKeyframes(const fs::path& folder, const Places& places, SavedAtlas* atlas) {
  core::CsvTable table(folder / "keyframes.csv", std::string(kKeyframeHead) + core::kCsvPoseHead);
  while (table.NextRow()) {
    HeldKeyframe held;
    held.sensor.keyframe = table.Number<uint32_t>(0, kMost);
    SavedSubmap& submap = NextSubmap(&table, places, atlas);
    held.sensor.p_keyframe = table.Point();
    held.T_map_keyframe = table.NextPose();
    submap.keyframes.push_back(held);
  }
}

void LoadClouds(const fs::path& folder, const Places& places, SavedAtlas* atlas) {
  core::CsvTable table(folder / "clouds.csv", std::string(kCloudHead) + core::kCsvPoseHead);
  while (table.NextRow()) {
    SavedSubmap& submap = NextSubmap(&table, places, atlas);
    const fs::path file = FileOf(&table, "cloud_");
    submap.clouds.push_back({table.NextPose(), ReadCloud(file).p_lidar});
  }
}

void LoadSubmaps(const fs::path& folder, SavedAtlas* atlas) {
  core::CsvTable table(folder / "submaps.csv", std::string(kSubmapHead) + core::kCsvPoseHead);
  Places places;
  std::vector<size_t> announced;
  while (table.NextRow()) {
    SavedSubmap submap;
    submap.id = table.Number<uint32_t>(0, kMost);
    submap.root = table.Number<uint32_t>(0, kMost);
    announced.push_back(table.Number<uint32_t>(0, kMost));
    submap.overlap = table.Number<double>(0.0, 1.0);
    const fs::path file = FileOf(&table, "submap_");
    submap.T_map_submap = table.NextPose();
    if (!places.emplace(submap.id, atlas->submaps.size()).second)
      table.Fail(fmt::format("line {}: submap {} is there twice", table.line(), submap.id));
    submap.contents = ReadSubmap(file, atlas->resolution_m);
    atlas->submaps.push_back(std::move(submap));
  }
  LoadKeyframes(folder, places, atlas);
  for (size_t i = 0; i < announced.size(); ++i) {
    const size_t found = atlas->submaps[i].keyframes.size();
    if (announced[i] != found)
      table.Fail(fmt::format("submap {}: {} keyframes announced, {} there", atlas->submaps[i].id,
                             announced[i], found));
  }
  LoadClouds(folder, places, atlas);
}

}  // namespace

bool IsAtlasFile(const std::string& name) {
  if (name.find('/') != std::string::npos) return false;
  const bool submap = name.starts_with("submap_") && name.ends_with(".atlas");
  const bool cloud = name.starts_with("cloud_") && name.ends_with(".ply");
  static const std::array<std::string, 5> kTables = {"atlas.csv", "submaps.csv", "keyframes.csv",
                                                     "clouds.csv", "files.csv"};
  return submap || cloud || std::find(kTables.begin(), kTables.end(), name) != kTables.end();
}

bool IsAtlasFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) &&
         (fs::exists(path / "files.csv", error) || fs::exists(path / "submaps.csv", error));
}

SavedAtlas ToSave(const std::vector<const Submap*>& by_precedence, double resolution_m,
                  const StateLogOdds& states, const core::Box3& keep_map) {
  SavedAtlas atlas{resolution_m, states, keep_map, {}};
  for (const Submap* submap : by_precedence) {
    SavedSubmap saved{submap->id,        submap->root, submap->overlap,         submap->T_map_submap,
                      submap->keyframes, {},           submap->contents.Share()};
    for (const AccumulatedCloud& cloud : submap->clouds)
      if (cloud.points.size() > 0) saved.clouds.push_back({cloud.T_submap_cloud, cloud.points.Points()});
    atlas.submaps.push_back(std::move(saved));
  }
  return atlas;
}

std::shared_ptr<const AtlasView> SavedAtlas::View() const {
  std::vector<PosedSubmap> posed;
  for (const SavedSubmap& submap : submaps) {
    auto outline = std::make_shared<const SubmapOutline>(OutlineOf(*submap.contents->Get()));
    posed.push_back({submap.id, submap.contents, states, submap.T_map_submap, std::move(outline)});
  }
  return std::make_shared<const AtlasView>(resolution_m, std::move(posed), keep_map);
}

void WriteAtlas(const fs::path& folder, const SavedAtlas& atlas) {
  core::CheckedFolderWriter writer(folder);
  std::string submaps = std::string(kSubmapHead) + core::kCsvPoseHead + "\n",
              keyframes = std::string(kKeyframeHead) + core::kCsvPoseHead + "\n",
              clouds = std::string(kCloudHead) + core::kCsvPoseHead + "\n";
  for (const SavedSubmap& submap : atlas.submaps) {
    const std::string file = SubmapFile(submap.id);
    const auto contents = submap.contents->Get();
    if (contents->distances) {
      WriteMap(writer.At(file), *contents->distances);
    } else {
      WriteMap(writer.At(file), contents->tree);
    }
    writer.Written(file);
    submaps += fmt::format("{},{},{},{:.4f},{},{}\n", submap.id, submap.root, submap.keyframes.size(),
                           submap.overlap, file, core::CsvOfPose(submap.T_map_submap));
    for (const HeldKeyframe& held : submap.keyframes) {
      const Vec3& p = held.sensor.p_keyframe;
      keyframes += fmt::format("{},{},{},{},{},{}\n", held.sensor.keyframe, submap.id, p.x(), p.y(), p.z(),
                               core::CsvOfPose(held.T_map_keyframe));
    }
    for (size_t k = 0; k < submap.clouds.size(); ++k) {
      const std::string name = fmt::format("cloud_{:03d}_{}.ply", submap.id, k);
      core::WritePly(writer.At(name), core::PointCloud{submap.clouds[k].points});
      writer.Written(name);
      clouds += fmt::format("{},{},{}\n", submap.id, name, core::CsvOfPose(submap.clouds[k].T_submap_cloud));
    }
  }
  const auto& [low, high] = std::pair(atlas.keep_map.min, atlas.keep_map.max);
  writer.Text("atlas.csv", fmt::format("{}\n{},{},{},{},{},{},{},{},{},{}\n", kAtlasHead, kAtlasFormat,
                                       atlas.resolution_m, atlas.states.free, atlas.states.occupied, low.x(),
                                       low.y(), low.z(), high.x(), high.y(), high.z()));
  writer.Text("submaps.csv", submaps);
  writer.Text("keyframes.csv", keyframes);
  writer.Text("clouds.csv", clouds);
  writer.Finish(IsAtlasFile);
}

double ResolutionOfAtlas(const fs::path& folder) {
  SavedAtlas head;
  LoadHead(folder, &head);
  return head.resolution_m;
}

SavedAtlas LoadAtlas(const fs::path& folder) {
  core::CheckFolder(folder, IsAtlasFile);
  SavedAtlas atlas;
  LoadHead(folder, &atlas);
  LoadSubmaps(folder, &atlas);
  return atlas;
}

}  // namespace atlas::mapping
