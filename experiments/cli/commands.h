// The commands behind `atlas`, one file each. Each returns the process's exit code and throws InputError for
// bad input.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/params.h"

namespace atlas::experiments {

struct RunArguments {
  std::string experiment;
  std::optional<uint64_t> seed;  ///< none: that of the file
  int threads = 2;
  std::vector<std::string> assignments;
  std::filesystem::path out;  ///< empty: runs/<experiment>/<seed>, numbered where that holds a run
  bool force = false;         ///< replaces the run that the folder holds
  bool video = false;
};
int RunCommand(const RunArguments& arguments);

struct RenderArguments {
  std::string what;  ///< run folder; for a still also a scene
  std::filesystem::path out;
  double speed = 8.0;  ///< times real time
  std::string size = "960x540";
  bool plan = false;  ///< the ground from above instead
  bool still = false;
  std::optional<double> still_time_s;  ///< simulated; the run's end without one
  std::vector<double> eye, target;     ///< map frame; empty: the camera finds its own place
};
int RenderCommand(const RenderArguments& arguments);

struct SweepArguments {
  std::string name;  ///< of experiments/configs/sweeps, or FILE.yaml
  int jobs = 0;      ///< runs at a time; 0: as many as cores
  int threads = 1;   ///< of each run
  std::filesystem::path out;
  bool slurm = false;
  double limit_s = 0.0;     ///< wall time of a run after which it is ended; 0: the sweep's own
  bool keep_stale = false;  ///< results of another configuration or commit count as done
};
int SweepCommand(const SweepArguments& arguments);

struct ReportArguments {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out;
};
int ReportCommand(const ReportArguments& arguments);

struct RecordArguments {
  std::string scene;
  std::filesystem::path route;  ///< empty: the scene's own
  std::string lidar = "os1_64";
  std::filesystem::path out;  ///< empty: runs/record/SCENE
  std::optional<int> scans;
  std::optional<double> rate_hz, speed_m_s;
  std::optional<double> truth_spacing_m;  ///< 0: no truth
  uint64_t seed = 1;
  std::string noise = "on";
  int threads = 2;
};
int RecordCommand(const RecordArguments& arguments);

struct CheckArguments {
  std::string scene;   ///< name, or path/scene.yaml
  bool truth = false;  ///< its ground truth too
};
/// Returns 1 where a solid is inside out or the ground truth is faulty.
int CheckSceneCommand(const CheckArguments& arguments);

/// Prints the entries of a kind, or the kinds where it is empty.
int ListCommand(const std::string& kind, bool verbose);
std::vector<std::string> ListKinds();
/// @throws InputError for an unknown kind, naming the near one.
std::vector<std::string> NamesOfKind(const std::string& kind);

struct ExplainArguments {
  std::string what;                   ///< experiment, FILE.yaml, or "map": what `atlas map` takes
  std::vector<std::string> prefixes;  ///< only keys that begin with one of these; empty: all
  std::vector<std::string> assignments;
};
int ExplainCommand(const ExplainArguments& arguments);
/// "KEY = VALUE UNIT | RANGE | ORIGIN | MEANING", a line a parameter in the order of declaration. A line
/// depends on its own parameter only, so that two outputs compare line by line. @throws InputError for a
/// prefix that no key begins with.
std::string ExplainText(const std::vector<core::ParamRow>& rows, const std::vector<std::string>& prefixes);

struct BenchArguments {
  std::string what;   ///< lidar | mapper | motion | correction | odometry | places
  std::string scene;  ///< only this one
  std::optional<double> range_m,
      resolution_m;  ///< mapper: with a scene, one setting instead of the standard ones
  int scans = 0;     ///< mapper, odometry: of the route; 0: all
  int threads = 1;
  std::string simd;  ///< mapper: the widest instructions that may be used
  bool octomap = true;
  std::filesystem::path out;  ///< default runs/bench_<what>
};
int BenchCommand(const BenchArguments& arguments);

}  // namespace atlas::experiments
