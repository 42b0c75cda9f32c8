#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "core/ply_format.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/progress_bar.h"
#include "experiments/judge/surface_score.h"
#include "experiments/report/text_table.h"
#include "mapping/atlas/saved_atlas.h"
#include "mapping/io/map_file.h"
#include "mapping/io/recorded_cloud.h"
#include "mapping/meshing/marching_cubes.h"
#include "scenes/ply_reader.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using core::Vec3f;

constexpr double kMaxSamples = 2e7;

/// What is compared with the truth, and in words what it is.
struct Subject {
  std::vector<Vec3f> points;
  std::string what;
};

std::vector<Vec3f> LoadCloud(const fs::path& path) {
  mapping::RecordedCloud cloud = mapping::ReadCloud(path);
  std::erase_if(cloud.p_lidar, [](const Vec3f& p) { return !p.allFinite(); });
  if (cloud.p_lidar.empty()) throw core::InputError(fmt::format("{}: holds no points", path.string()));
  return std::move(cloud.p_lidar);
}

Subject OfMesh(const core::TriMesh& mesh, const EvalArguments& arguments) {
  const double spacing_m = std::max(arguments.spacing_m, std::sqrt(mesh.AreaM2() / kMaxSamples));
  Subject subject{SampleMesh(mesh, spacing_m), ""};
  subject.what = fmt::format("mesh of {} triangles, {} samples {:.1f} cm apart", mesh.triangles.size(),
                             subject.points.size(), 100.0 * spacing_m);
  return subject;
}

Subject OfAtlas(const EvalArguments& arguments) {
  const mapping::SavedAtlas atlas = mapping::LoadAtlas(arguments.subject);
  if (arguments.points == "voxels") {
    Subject subject{mapping::SurfaceVoxels(atlas).points, ""};
    subject.what =
        fmt::format("{} surface voxels of {} submaps", subject.points.size(), atlas.submaps.size());
    return subject;
  }
  mapping::MeshOptions options;
  options.threads = arguments.threads;
  return OfMesh(mapping::ExtractMesh(atlas, options), arguments);
}

Subject OfMap(const EvalArguments& arguments) {
  const mapping::AnyOctree map = mapping::ReadMap(arguments.subject);
  if (arguments.points == "voxels") {
    Subject subject{std::visit([](const auto& tree) { return mapping::SurfaceVoxels(tree).points; }, map),
                    ""};
    subject.what = fmt::format("{} surface voxels", subject.points.size());
    return subject;
  }
  mapping::MeshOptions options;
  options.threads = arguments.threads;
  return OfMesh(std::visit([&](const auto& tree) { return mapping::ExtractMesh(tree, options); }, map),
                arguments);
}

/// Whether a PLY file has faces, by its header.
bool IsMesh(const fs::path& path) {
  if (path.extension() != ".ply") return false;
  try {
    for (const core::PlyElement& element : core::ReadPlyHeader(core::ReadFile(path)).elements) {
      if (element.name == "face" && element.count > 0) return true;
    }
  } catch (const core::InputError&) {
    return false;  // the reader of clouds tells what is wrong
  }
  return false;
}

Subject LoadSubject(const EvalArguments& arguments) {
  Subject subject;
  if (mapping::IsAtlasFolder(arguments.subject)) {
    subject = OfAtlas(arguments);
  } else if (mapping::IsMapFile(arguments.subject) || arguments.subject.extension() == ".atlas") {
    subject = OfMap(arguments);
  } else if (IsMesh(arguments.subject)) {
    try {
      subject = OfMesh(scenes::ParsePly(core::ReadFile(arguments.subject)), arguments);
    } catch (const core::InputError& error) {
      throw core::InputError(fmt::format("{}: {}", arguments.subject.string(), error.what()));
    }
  } else {
    subject = {LoadCloud(arguments.subject), ""};
    subject.what = fmt::format("cloud of {} points", subject.points.size());
  }
  if (subject.points.empty()) {
    throw core::InputError(fmt::format("{}: holds no surface to compare", arguments.subject.string()));
  }
  return subject;
}

std::string Centimetres(double metres) {
  return fmt::format("{:.2f} cm", 100.0 * metres);
}
std::string Percent(double share) {
  return fmt::format("{:.2f} %", 100.0 * share);
}

TextTable ScoreTable(const SurfaceScore& raw, const SurfaceScore& aligned, const EvalArguments& arguments) {
  TextTable table;
  table.heading = {"distances", "as is", "aligned"};
  table.left = {true, false, false};
  const auto row = [&](const std::string& name, const auto& text, double a, double b) {
    table.rows.push_back({name, text(a), text(b)});
  };
  row("accuracy, mean", Centimetres, raw.accuracy_mean_m, aligned.accuracy_mean_m);
  row("accuracy, median", Centimetres, raw.accuracy_median_m, aligned.accuracy_median_m);
  row("accuracy, p95", Centimetres, raw.accuracy_p95_m, aligned.accuracy_p95_m);
  row(fmt::format("no truth within {} m", arguments.limit_m), Percent, raw.outlier_share,
      aligned.outlier_share);
  row("completeness, mean", Centimetres, raw.completeness_mean_m, aligned.completeness_mean_m);
  for (size_t k = 0; k < arguments.radii_m.size(); ++k) {
    row(fmt::format("coverage at {:.1f} cm", 100.0 * arguments.radii_m[k]), Percent, raw.coverage[k],
        aligned.coverage[k]);
  }
  return table;
}

nlohmann::ordered_json ToJson(const SurfaceScore& score, const std::vector<double>& radii_m) {
  nlohmann::ordered_json json = {{"accuracy_mean_m", score.accuracy_mean_m},
                                 {"accuracy_median_m", score.accuracy_median_m},
                                 {"accuracy_p95_m", score.accuracy_p95_m},
                                 {"outlier_share", score.outlier_share},
                                 {"completeness_mean_m", score.completeness_mean_m}};
  for (size_t k = 0; k < radii_m.size(); ++k) {
    json["coverage"].push_back({{"radius_m", radii_m[k]}, {"share", score.coverage[k]}});
  }
  return json;
}

}  // namespace

int EvalCommand(const EvalArguments& given) {
  EvalArguments arguments = given;
  if (arguments.radii_m.empty()) arguments.radii_m = {0.043, 0.086};
  ProgressBar bar("eval", 4);
  bar.Show(0, "reading " + arguments.truth.string());
  const SurfaceScorer scorer(LoadCloud(arguments.truth),
                             {arguments.radii_m, arguments.limit_m, arguments.threads});
  bar.Show(1, "reading " + arguments.subject.string());
  const Subject subject = LoadSubject(arguments);
  bar.Show(2, "as is");
  const SurfaceScore raw = scorer.Score(subject.points, core::Pose::Identity());
  bar.Show(3, "aligned");
  const AlignResult fit = scorer.Align(subject.points);
  const SurfaceScore aligned = scorer.Score(subject.points, fit.T_truth_cloud);
  bar.Finish(fmt::format("{} against {} truth points", subject.what, scorer.truth_count()));

  const double turned_deg = core::Degrees(Eigen::AngleAxisd(fit.T_truth_cloud.linear()).angle());
  const double moved_m = fit.T_truth_cloud.translation().norm();
  std::cout << ToTerminal(ScoreTable(raw, aligned, arguments));
  std::cout << fmt::format("aligned by {:.1f} mm and {:.3f} deg ({} pairs, {:.1f} mm rms)\n", 1e3 * moved_m,
                           turned_deg, fit.pairs, 1e3 * fit.rms_m);
  if (!arguments.json.empty()) {
    const nlohmann::ordered_json json = {{"subject", arguments.subject.string()},
                                         {"truth", arguments.truth.string()},
                                         {"surface_points", subject.points.size()},
                                         {"truth_points", scorer.truth_count()},
                                         {"distance_limit_m", arguments.limit_m},
                                         {"as_is", ToJson(raw, arguments.radii_m)},
                                         {"aligned", ToJson(aligned, arguments.radii_m)},
                                         {"alignment_m", moved_m},
                                         {"alignment_deg", turned_deg}};
    core::WriteFileAtomically(arguments.json, json.dump(2) + "\n");
  }
  return 0;
}

}  // namespace atlas::experiments
