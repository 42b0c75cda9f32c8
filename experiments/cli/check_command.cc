// Is a scene sound, and is its ground truth what it says?
#include <fmt/format.h>

#include <iostream>

#include "experiments/cli/commands.h"
#include "scenes/catalog.h"
#include "scenes/truth_check.h"

namespace atlas::experiments {
namespace {

constexpr int kDraws = 100000;

void PrintBox(const char* name, const core::Box3& box) {
  std::cout << fmt::format("  {:<11} x {:.2f} to {:.2f}, y {:.2f} to {:.2f}, z {:.2f} to {:.2f} m\n", name,
                           box.min.x(), box.max.x(), box.min.y(), box.max.y(), box.min.z(), box.max.z());
}

/// Whether no face of a closed solid looks inward. Open meshes are told of, not faulted.
bool CheckMeshes(const scenes::SceneSpec& scene) {
  std::cout << fmt::format("{}: {}\n", scene.name, scene.doc);
  PrintBox("bounds", scene.bounds);
  PrintBox("object box", scene.object_box);
  const core::Vec3& spawn = scene.T_map_spawn.translation();
  std::cout << fmt::format("  spawn       ({:.2f}, {:.2f}), {:.2f} m from the object box\n", spawn.x(),
                           spawn.y(), scene.object_box.DistanceTo(spawn + core::Vec3(0, 0, 0.5)));
  size_t triangles = 0, shells = 0, open = 0, inward = 0;
  for (const scenes::PartReport& part : scenes::CheckParts(scene)) {
    triangles += part.triangles;
    shells += part.shells;
    open += part.open_shells;
    inward += part.inward_shells;
    if (part.open_shells > 0) {
      std::cout << fmt::format(
          "  note: {}: {} of {} pieces enclose no volume: they bury nothing, both their "
          "sides count\n",
          part.name, part.open_shells, part.shells);
    }
    if (part.inward_shells > 0) {
      std::cout << fmt::format("  fault: {}: {} of {} solids are inside out\n", part.name, part.inward_shells,
                               part.shells);
    }
    if (part.flat_triangles > 0) {
      std::cout << fmt::format("  note: {}: {} triangles have no area\n", part.name, part.flat_triangles);
    }
  }
  std::cout << fmt::format("  meshes      {} triangles in {} pieces, {} open, {} inside out\n", triangles,
                           shells, open, inward);
  return inward == 0;
}

bool CheckGroundTruth(const scenes::SceneSpec& scene) {
  const double spacing_m = scene.truth_spacing_m;
  const scenes::GroundTruth truth = scenes::SampleGroundTruth(scene, spacing_m);
  const scenes::TruthReport report = scenes::CheckTruth(scene, truth, spacing_m, kDraws);
  std::cout << fmt::format("ground truth: {} points, one per {:g} cm squared\n", report.points,
                           100.0 * spacing_m);
  const auto share = [](size_t part, size_t all) {
    return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<size_t>(1, all));
  };
  std::cout << fmt::format(
      "  to the mesh: {} points ({:.3f} %) farther than {:g} mm; mean {:.4f} mm, greatest {:.4f} mm\n",
      report.off_mesh, share(report.off_mesh, report.points), 1e3 * scenes::TruthReport::kOffMesh_m,
      1e3 * report.mean_m, 1e3 * report.greatest_m);
  std::cout << fmt::format(
      "  completeness: of {} surface points drawn {} are exposed; {} of them ({:.3f} %) have no truth within "
      "the spacing;\n  widest gap {:.2f} spacings, at ({:.2f}, {:.2f}, {:.2f})\n",
      report.drawn, report.exposed, report.missed, share(report.missed, report.exposed),
      report.worst_gap_m / spacing_m, report.worst_gap_map.x(), report.worst_gap_map.y(),
      report.worst_gap_map.z());
  std::vector<size_t> points(truth.part_names.size());
  for (const uint16_t part : truth.part) ++points[part];
  for (size_t i = 0; i < points.size(); ++i) {
    std::cout << fmt::format("  {:<28} {:9.2f} m2 {:9} points\n", truth.part_names[i], truth.part_area_m2[i],
                             points[i]);
  }
  std::cout << (report.good() ? "ground truth: sound\n" : "ground truth: FAULTY\n");
  return report.good();
}

}  // namespace

int CheckSceneCommand(const CheckArguments& arguments) {
  const scenes::SceneSpec scene = scenes::LoadScene(arguments.scene);
  bool good = CheckMeshes(scene);
  if (arguments.truth) good = CheckGroundTruth(scene) && good;
  return good ? 0 : 1;
}

}  // namespace atlas::experiments
