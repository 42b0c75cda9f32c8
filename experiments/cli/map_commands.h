// `atlas map`, `slam`, `mesh`, `eval` and `export`: the mapper alone, on recorded LiDAR. `atlas posegraph`:
// the back end alone.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/params.h"
#include "mapping/io/recorded_log.h"

namespace atlas::experiments {

struct MapArguments {
  mapping::RecordedLogOptions log;
  std::string no_return = "dropout";
  std::string field = "occupancy";
  double resolution_m = 0.065;
  double max_range_m = 60.0;
  double local_radius_m = 0.0;  ///< 0: all is kept
  size_t limit = 0;             ///< the first so many scans; 0: all
  bool skip_unreadable = false;
  bool mesh = false;
  int threads = 2;
  std::vector<std::string> assignments;
  std::filesystem::path out;  ///< empty: runs/map/NAME
};
int MapCommand(const MapArguments& arguments);
/// Every parameter of the mapper as `atlas map` would run it. @throws InputError for a bad assignment.
std::vector<core::ParamRow> ExplainMap(const MapArguments& arguments);

struct SlamArguments {
  mapping::RecordedLogOptions log;
  std::filesystem::path odometry;  ///< TUM: the user's own; empty: none
  std::filesystem::path earlier;   ///< the atlas to go on from, or the folder of its run; empty: none
  std::string no_return = "dropout";
  std::optional<double> resolution_m;  ///< absent: as the earlier atlas has it, else 0.1
  double max_range_m = 60.0;
  size_t limit = 0;  ///< the first so many scans; 0: all
  int threads = 2;
  std::vector<std::string> assignments;
  std::filesystem::path out;  ///< empty: runs/slam/NAME
};
/// Maps a log that has no poses.
int SlamCommand(const SlamArguments& arguments);

struct MeshArguments {
  std::filesystem::path map, out;
  double min_component_m2 = 0.0;
  int threads = 2;
};
int MeshCommand(const MeshArguments& arguments);

struct EvalArguments {
  std::filesystem::path subject, truth;
  std::vector<double> radii_m;  ///< empty: 0.043 and 0.086
  std::string points = "mesh";  ///< of a map: mesh (samples of its surface) | voxels (centres)
  double spacing_m = 0.02;      ///< between samples of a mesh
  double limit_m = 0.5;         ///< longer distances count as this
  std::filesystem::path json;   ///< empty: none is written
  int threads = 2;
};
int EvalCommand(const EvalArguments& arguments);

struct ExportArguments {
  std::filesystem::path map, out;
};
int ExportCommand(const ExportArguments& arguments);

struct PoseGraphArguments {
  std::filesystem::path graph, out, truth;  ///< out, truth: empty for none
  std::string robust = "none";              ///< none | dcs | gnc
  std::string cost = "log";                 ///< log | chordal | g2o: whose minimum is written and compared
};
/// Returns 1 where the optimiser found nothing better than its start.
int PoseGraphCommand(const PoseGraphArguments& arguments);

}  // namespace atlas::experiments
