#include "mapping/atlas/saved_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/text_lines.h"
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
constexpr const char* kPoseHead = "x_m,y_m,z_m,qx,qy,qz,qw";
constexpr const char* kSubmapHead = "submap,root_keyframe,keyframes,overlap,file,";
constexpr const char* kKeyframeHead = "keyframe,submap,sensor_x_m,sensor_y_m,sensor_z_m,";
constexpr const char* kCloudHead = "submap,file,";
constexpr const char* kFilesHead = "file,bytes,crc64";
constexpr double kFarthestM = 1e7;

std::string TextOfPose(const Pose& T) {
  const Vec3& p = T.translation();
  const Eigen::Quaterniond q(T.linear());
  return fmt::format("{:.9f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f},{:.12f}", p.x(), p.y(), p.z(), q.x(),
                     q.y(), q.z(), q.w());
}

/// A table's rows, value by value; says where a value is wrong.
class CsvTable {
 public:
  CsvTable(const fs::path& path, const std::string& head)
      : path_(path), head_(head), text_(core::ReadFile(path)), lines_(text_), columns_(SplitCells(head_)) {
    const auto first = lines_.Next();
    if (!first || *first != head) Fail(fmt::format("does not begin with {}", head));
  }

  bool NextRow() {
    const auto line = lines_.Next();
    if (!line) return false;
    cells_ = SplitCells(*line);
    at_ = 0;
    if (cells_.size() != columns_.size())
      Fail(fmt::format("line {}: {} values, must be {}", lines_.number(), cells_.size(), columns_.size()));
    return true;
  }
  template <typename T>
  T Number(T least, T most) {
    const std::string_view cell = cells_[at_];
    const auto value = core::ParseNumber<T>(cell);
    if (!value || !(*value >= least && *value <= most)) {
      Fail(
          fmt::format("line {}: {} {}, must be {} to {}", lines_.number(), columns_[at_], cell, least, most));
    }
    ++at_;
    return *value;
  }
  double Coordinate() { return Number<double>(-kFarthestM, kFarthestM); }
  Vec3 Point() {
    const double x = Coordinate(), y = Coordinate();
    return {x, y, Coordinate()};
  }
  Pose NextPose() {
    const Vec3 p = Point();
    double q[4];
    for (double& part : q) part = Number<double>(-1.0, 1.0);
    const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
    if (std::abs(turn.norm() - 1.0) > 1e-6)
      Fail(fmt::format("line {}: quaternion of length {}, must be 1", lines_.number(), turn.norm()));
    return core::MakePose(turn.normalized().toRotationMatrix(), p);
  }
  std::string_view Word() { return cells_[at_++]; }
  /// A file of the folder itself.
  fs::path File(const std::string& prefix) {
    const std::string_view name = Word();
    if (!name.starts_with(prefix) || !IsAtlasFile(std::string(name)))
      Fail(fmt::format("line {}: file {}, must be {}...", lines_.number(), name, prefix));
    return path_.parent_path() / name;
  }
  [[noreturn]] void Fail(const std::string& reason) const {
    throw core::InputError(fmt::format("{}: {}", path_.string(), reason));
  }
  size_t line() const { return lines_.number(); }

 private:
  static std::vector<std::string_view> SplitCells(std::string_view line) {
    std::vector<std::string_view> cells;
    for (size_t begin = 0; begin <= line.size();) {
      const size_t end = std::min(line.find(',', begin), line.size());
      cells.push_back(line.substr(begin, end - begin));
      begin = end + 1;
    }
    return cells;
  }

  fs::path path_;
  std::string head_, text_;
  core::TextLines lines_;
  std::vector<std::string_view> columns_, cells_;
  size_t at_ = 0;
};

/// Remembers what it wrote.
class FolderWriter {
 public:
  explicit FolderWriter(fs::path folder) : folder_(std::move(folder)) {}
  void Text(const std::string& name, const std::string& content) {
    core::WriteFileAtomically(folder_ / name, content);
    Written(name);
  }
  void Written(const std::string& name) {
    const std::string content = core::ReadFile(folder_ / name);
    list_ += fmt::format("{},{},{:016x}\n", name, content.size(), core::Crc64(content));
  }
  fs::path At(const std::string& name) const { return folder_ / name; }
  /// What an atlas that was saved there before has left.
  void RemoveOthers() const {
    std::vector<fs::path> others;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (IsAtlasFile(name) && name != "files.csv" && list_.find("\n" + name + ",") == std::string::npos)
        others.push_back(entry.path());
    }
    for (const fs::path& file : others) fs::remove(file);
  }
  /// The list closes with its own checksum.
  void Finish() {
    RemoveOthers();
    core::WriteFileAtomically(folder_ / "files.csv", list_ + fmt::format("files.csv,{},{:016x}\n",
                                                                         list_.size(), core::Crc64(list_)));
  }

 private:
  fs::path folder_;
  std::string list_ = std::string(kFilesHead) + "\n";
};

/// Every file of the list is there as it was written.
void CheckFiles(const fs::path& folder) {
  const fs::path list = folder / "files.csv";
  CsvTable table(list, kFilesHead);
  const std::string text = core::ReadFile(list);
  bool whole = false;
  while (table.NextRow()) {
    if (whole) table.Fail(fmt::format("line {}: after the end", table.line()));
    const std::string name(table.Word());
    const auto bytes = table.Number<uint64_t>(0, std::numeric_limits<int64_t>::max());
    const std::string crc(table.Word());
    whole = name == "files.csv";
    if (!whole && !IsAtlasFile(name))
      table.Fail(fmt::format("line {}: no file of an atlas: {}", table.line(), name));
    const std::string content = whole ? text.substr(0, bytes) : core::ReadFile(folder / name);
    if (content.size() != bytes) {
      throw core::InputError(
          fmt::format("{}: damaged: {} bytes, must be {}", (folder / name).string(), content.size(), bytes));
    }
    if (const std::string found = fmt::format("{:016x}", core::Crc64(content)); found != crc) {
      throw core::InputError(
          fmt::format("{}: damaged: checksum {}, must be {}", (folder / name).string(), found, crc));
    }
  }
  if (!whole) table.Fail("ends early: its own checksum is missing");
}

std::string SubmapFile(uint32_t id) {
  return fmt::format("submap_{:03d}.atlas", id);
}

std::shared_ptr<const StoredContents> ReadSubmap(const fs::path& file, double resolution_m) {
  AnyOctree map = ReadMap(file);
  auto* const tree = std::get_if<OccupancyOctree>(&map);
  if (tree == nullptr)
    throw core::InputError(fmt::format("{}: field tsdf, must be occupancy", file.string()));
  if (tree->resolution_m() != resolution_m) {
    throw core::InputError(
        fmt::format("{}: resolution {} m, must be {}", file.string(), tree->resolution_m(), resolution_m));
  }
  return std::make_shared<const StoredContents>(std::make_shared<ContentsPager>(0),
                                                OctreeContents{std::move(*tree), {}});
}

void LoadHead(const fs::path& folder, SavedAtlas* atlas) {
  CsvTable table(folder / "atlas.csv", kAtlasHead);
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

SavedSubmap& NextSubmap(CsvTable* table, const Places& places, SavedAtlas* atlas) {
  const auto found = places.find(table->Number<uint32_t>(0, kMost));
  if (found == places.end())
    table->Fail(fmt::format("line {}: of a submap that is not there", table->line()));
  return atlas->submaps[found->second];
}

void LoadKeyframes(const fs::path& folder, const Places& places, SavedAtlas* atlas) {
  CsvTable table(folder / "keyframes.csv", std::string(kKeyframeHead) + kPoseHead);
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
  CsvTable table(folder / "clouds.csv", std::string(kCloudHead) + kPoseHead);
  while (table.NextRow()) {
    SavedSubmap& submap = NextSubmap(&table, places, atlas);
    const fs::path file = table.File("cloud_");
    submap.clouds.push_back({table.NextPose(), ReadCloud(file).p_lidar});
  }
}

void LoadSubmaps(const fs::path& folder, SavedAtlas* atlas) {
  CsvTable table(folder / "submaps.csv", std::string(kSubmapHead) + kPoseHead);
  Places places;
  std::vector<size_t> announced;
  while (table.NextRow()) {
    SavedSubmap submap;
    submap.id = table.Number<uint32_t>(0, kMost);
    submap.root = table.Number<uint32_t>(0, kMost);
    announced.push_back(table.Number<uint32_t>(0, kMost));
    submap.overlap = table.Number<double>(0.0, 1.0);
    const fs::path file = table.File("submap_");
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
  FolderWriter writer(folder);
  std::string submaps = std::string(kSubmapHead) + kPoseHead + "\n",
              keyframes = std::string(kKeyframeHead) + kPoseHead + "\n",
              clouds = std::string(kCloudHead) + kPoseHead + "\n";
  for (const SavedSubmap& submap : atlas.submaps) {
    const std::string file = SubmapFile(submap.id);
    WriteMap(writer.At(file), submap.contents->Get()->tree);
    writer.Written(file);
    submaps += fmt::format("{},{},{},{:.4f},{},{}\n", submap.id, submap.root, submap.keyframes.size(),
                           submap.overlap, file, TextOfPose(submap.T_map_submap));
    for (const HeldKeyframe& held : submap.keyframes) {
      const Vec3& p = held.sensor.p_keyframe;
      keyframes += fmt::format("{},{},{},{},{},{}\n", held.sensor.keyframe, submap.id, p.x(), p.y(), p.z(),
                               TextOfPose(held.T_map_keyframe));
    }
    for (size_t k = 0; k < submap.clouds.size(); ++k) {
      const std::string name = fmt::format("cloud_{:03d}_{}.ply", submap.id, k);
      core::WritePly(writer.At(name), core::PointCloud{submap.clouds[k].points});
      writer.Written(name);
      clouds += fmt::format("{},{},{}\n", submap.id, name, TextOfPose(submap.clouds[k].T_submap_cloud));
    }
  }
  const auto& [low, high] = std::pair(atlas.keep_map.min, atlas.keep_map.max);
  writer.Text("atlas.csv", fmt::format("{}\n{},{},{},{},{},{},{},{},{},{}\n", kAtlasHead, kAtlasFormat,
                                       atlas.resolution_m, atlas.states.free, atlas.states.occupied, low.x(),
                                       low.y(), low.z(), high.x(), high.y(), high.z()));
  writer.Text("submaps.csv", submaps);
  writer.Text("keyframes.csv", keyframes);
  writer.Text("clouds.csv", clouds);
  writer.Finish();
}

SavedAtlas LoadAtlas(const fs::path& folder) {
  CheckFiles(folder);
  SavedAtlas atlas;
  LoadHead(folder, &atlas);
  LoadSubmaps(folder, &atlas);
  return atlas;
}

}  // namespace atlas::mapping
