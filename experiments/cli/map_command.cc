#include <fmt/format.h>

#include <exception>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "core/resource_use.h"
#include "core/safe_text.h"
#include "core/stopwatch.h"
#include "experiments/cli/interrupt.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/progress_bar.h"
#include "experiments/mapping_tools/offline_map.h"
#include "experiments/report/text_table.h"
#include "experiments/results/run_folder.h"
#include "experiments/results/statistics.h"
#include "mapping/meshing/marching_cubes.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using core::Vec3;

constexpr double kFarOriginM = 5000.0;  ///< beyond, single precision is coarser than half a millimetre

/// What the log came to.
struct MapOutcome {
  size_t scans = 0, unreadable = 0, rays = 0;
  std::vector<double> cpu_ms, wall_ms;  ///< a scan each, integration alone
  bool interrupted = false;
  std::string first_error;    ///< of the scans that were left out
  std::exception_ptr broken;  ///< what ended the log before its time
  std::string why_broken;

  /// Keeps the first.
  void Break(const std::exception& error) {
    if (broken) return;
    broken = std::current_exception();
    why_broken = error.what();
  }
  std::string_view status() const { return broken ? "failed" : interrupted ? "interrupted" : "completed"; }
};

OfflineMapParams ParamsOf(const MapArguments& arguments, std::vector<core::ParamRow>* rows = nullptr) {
  struct {
    OfflineMapParams mapper;
    void Visit(core::ParamVisitor& v) { v.Section("mapper", &mapper); }
  } root;
  root.mapper.field = arguments.field;
  root.mapper.resolution_m = arguments.resolution_m;
  root.mapper.local_radius_m = arguments.local_radius_m;
  root.mapper.integrator.max_range_m = arguments.max_range_m;
  root.mapper.integrator.threads = arguments.threads;
  core::ParamSource source;
  for (const std::string& assignment : arguments.assignments) source.MergeAssignment(assignment);
  auto loaded = source.Load(&root);
  if (rows != nullptr) *rows = std::move(loaded);
  return root.mapper;
}

/// The folder's or file's own name: runs/map/NAME.
fs::path DefaultFolder(const std::string& scans) {
  const fs::path path = fs::path(scans).lexically_normal();
  const fs::path name = path.has_filename() ? path.stem() : path.parent_path().filename();
  return fs::path("runs") / "map" / (name.empty() || name == "." || name == ".." ? fs::path("log") : name);
}

/// Poses far from their origin (UTM, national grids) are mapped about the first one instead.
Vec3 OriginOf(const mapping::RecordedLog& log) {
  const Vec3 first = log.T_map_lidar(0).translation();
  if (first.norm() < kFarOriginM) return Vec3::Zero();
  return (first / 100.0).array().round() * 100.0;
}

/// One scan after another. @throws what reading or integrating one throws; `outcome` is of those before it.
void Integrate(const MapArguments& arguments, const mapping::RecordedLog& log, const Vec3& origin,
               OfflineMapper* mapper, MapOutcome* result) {
  MapOutcome& outcome = *result;
  core::Pose T_map_odom = core::Pose::Identity();
  T_map_odom.translation() = -origin;
  const size_t count = arguments.limit > 0 ? std::min(arguments.limit, log.size()) : log.size();
  ProgressBar bar("map", count);
  for (size_t i = 0; i < count && !(outcome.interrupted = Interrupted()); ++i) {
    bar.Show(i, fmt::format("{:.1f} MB", static_cast<double>(mapper->MapBytes()) / 1e6));
    core::SpinEvent spin;
    try {
      spin = log.Read(i);
    } catch (const core::InputError& error) {
      if (!arguments.skip_unreadable) throw;
      if (outcome.unreadable++ == 0) outcome.first_error = error.what();
      continue;
    }
    const double cpu_s = core::CpuSeconds();
    const core::Stopwatch watch;
    mapper->Add(spin, T_map_odom);
    outcome.cpu_ms.push_back(1e3 * (core::CpuSeconds() - cpu_s));
    outcome.wall_ms.push_back(1e3 * watch.seconds());
    outcome.rays += spin.scan.size();
    ++outcome.scans;
  }
  bar.Finish(fmt::format("{} scans{}", outcome.scans, outcome.interrupted ? ", interrupted" : ""));
}

void WriteMesh(const fs::path& path, const OfflineMapper& mapper, int threads) {
  mapping::MeshOptions options;
  options.threads = threads;
  core::WritePly(
      path, std::visit([&](const auto& tree) { return mapping::ExtractMesh(tree, options); }, mapper.map()));
}

/// Each file on its own: one that fails does not cost the others.
void WriteOutputs(const MapArguments& arguments, const OfflineMapper& mapper, const fs::path& folder,
                  MapOutcome* outcome) {
  ProgressBar bar("write", arguments.mesh ? 3 : 2);
  size_t done = 0;
  const auto write = [&](const char* name, const std::function<void(const fs::path&)>& to) {
    bar.Show(done++, name);
    try {
      to(folder / name);
    } catch (const std::exception& error) {
      outcome->Break(error);
    }
  };
  write("map.atlas", [&](const fs::path& path) {
    std::visit([&](const auto& tree) { mapping::WriteMap(path, tree); }, mapper.map());
  });
  write("cloud.ply", [&](const fs::path& path) { core::WritePly(path, mapper.Cloud()); });
  if (arguments.mesh) {
    write("mesh.ply", [&](const fs::path& path) { WriteMesh(path, mapper, arguments.threads); });
  }
  bar.Finish(folder.string());
}

/// 0 where there is none.
uintmax_t BytesOf(const fs::path& file) {
  std::error_code error;
  const uintmax_t bytes = fs::file_size(file, error);
  return error ? 0 : bytes;
}

double MeanOf(const std::vector<double>& values) {
  return Describe(values).mean;
}

TextTable OutcomeTable(const MapOutcome& outcome, const mapping::RecordedLog& log,
                       const OfflineMapper& mapper, const OfflineMapParams& params, const fs::path& folder) {
  const MapVolume volume = VolumeOf(mapper.map());
  TextTable table;
  table.heading = {params.field + " map", fmt::format("{} cm", 100.0 * params.resolution_m)};
  table.left = {true, false};
  const auto row = [&](const std::string& name, std::string value) {
    table.rows.push_back({name, std::move(value)});
  };
  row("scans", fmt::format("{}", outcome.scans));
  row("scans without pose", fmt::format("{}", log.scans_without_pose()));
  if (outcome.unreadable > 0) row("scans unreadable", fmt::format("{}", outcome.unreadable));
  row("rays", fmt::format("{}", outcome.rays));
  row("CPU ms a scan, mean", fmt::format("{:.1f}", MeanOf(outcome.cpu_ms)));
  row("CPU ms a scan, p95", fmt::format("{:.1f}", Percentile(outcome.cpu_ms, 0.95)));
  row("wall ms a scan, mean", fmt::format("{:.1f}", MeanOf(outcome.wall_ms)));
  row("map in memory, MB", fmt::format("{:.2f}", static_cast<double>(mapper.MapBytes()) / 1e6));
  row("map.atlas, MB", fmt::format("{:.2f}", static_cast<double>(BytesOf(folder / "map.atlas")) / 1e6));
  row("peak memory, MB", fmt::format("{:.1f}", core::PeakResidentBytes() / 1e6));
  row("free, m3", fmt::format("{:.2f}", volume.free_m3));
  row("occupied, m3", fmt::format("{:.3f}", volume.occupied_m3));
  return table;
}

void WriteSummary(const fs::path& folder, const MapArguments& arguments, const OfflineMapParams& params,
                  const MapOutcome& outcome, const mapping::RecordedLog& log, const Vec3& origin,
                  const OfflineMapper& mapper) {
  const MapVolume volume = VolumeOf(mapper.map());
  nlohmann::ordered_json json = {{"status", outcome.status()},
                                 {"log", log.Describe()},
                                 {"scan_source", arguments.log.scans},
                                 {"field", params.field},
                                 {"resolution_m", params.resolution_m},
                                 {"max_range_m", params.integrator.max_range_m},
                                 {"local_radius_m", params.local_radius_m},
                                 {"threads", arguments.threads},
                                 {"map_origin_m", {origin.x(), origin.y(), origin.z()}},
                                 {"scans", outcome.scans},
                                 {"scans_without_pose", log.scans_without_pose()},
                                 {"scans_unreadable", outcome.unreadable},
                                 {"rays", outcome.rays},
                                 {"integration_cpu_ms_mean", MeanOf(outcome.cpu_ms)},
                                 {"integration_cpu_ms_p95", Percentile(outcome.cpu_ms, 0.95)},
                                 {"integration_ms_mean", MeanOf(outcome.wall_ms)},
                                 {"integration_ms_p95", Percentile(outcome.wall_ms, 0.95)},
                                 {"map_bytes", mapper.MapBytes()},
                                 {"map_file_bytes", BytesOf(folder / "map.atlas")},
                                 {"peak_rss_bytes", static_cast<uint64_t>(core::PeakResidentBytes())},
                                 {"free_m3", volume.free_m3},
                                 {"occupied_m3", volume.occupied_m3}};
  if (outcome.broken) json["error"] = outcome.why_broken;
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;  // of names that are no UTF-8
  core::WriteFileAtomically(folder / "summary.json", json.dump(2, ' ', false, kReplace) + "\n");
}

}  // namespace

std::vector<core::ParamRow> ExplainMap(const MapArguments& arguments) {
  std::vector<core::ParamRow> rows;
  ParamsOf(arguments, &rows);
  return rows;
}

int MapCommand(const MapArguments& arguments) {
  EndAtOnceOnSignal();
  const OfflineMapParams params = ParamsOf(arguments);
  mapping::RecordedLogOptions options = arguments.log;
  options.no_return = arguments.no_return == "void" ? core::ReturnKind::kVoid : core::ReturnKind::kDropout;
  const fs::path folder = arguments.out.empty() ? DefaultFolder(options.scans) : arguments.out;
  if (HoldsRun(folder)) {
    throw core::InputError(folder.string() +
                           ": holds a run, whose map this would overwrite (choose another --out)");
  }
  const mapping::RecordedLog log(options);
  core::RemoveStaleTemporaries(folder);
  core::AtomicFile(folder / "map.atlas");  // a folder that cannot be written is found before the work
  std::cout << core::Printable(log.Describe()) << std::endl;
  const Vec3 origin = OriginOf(log);
  if (!origin.isZero()) {
    std::cout << fmt::format(
        "poses lie far from their origin: the map's is ({:.0f}, {:.0f}, {:.0f}) of theirs\n", origin.x(),
        origin.y(), origin.z());
  }

  std::optional<core::LidarModel> lidar;
  if (log.beams()) lidar = log.beams()->model;
  OfflineMapper mapper(params, lidar);
  StopInOrderOnSignal();
  MapOutcome outcome;
  try {
    Integrate(arguments, log, origin, &mapper, &outcome);
  } catch (const std::exception& error) {
    if (outcome.scans == 0) throw;
    outcome.Break(error);
  }
  if (outcome.unreadable > 0) std::cout << "left out: " << outcome.first_error << "\n";
  WriteOutputs(arguments, mapper, folder, &outcome);
  WriteSummary(folder, arguments, params, outcome, log, origin, mapper);
  std::cout << ToTerminal(OutcomeTable(outcome, log, mapper, params, folder));
  std::cout << fmt::format("{}: map.atlas cloud.ply {}summary.json\n", folder.string(),
                           arguments.mesh ? "mesh.ply " : "");
  if (outcome.broken) std::rethrow_exception(outcome.broken);
  return outcome.interrupted ? 130 : 0;
}

}  // namespace atlas::experiments
