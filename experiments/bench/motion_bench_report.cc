#include <fmt/format.h>

#include "core/files.h"
#include "experiments/bench/motion_bench.h"
#include "experiments/report/text_table.h"

namespace atlas::experiments {
namespace {

using core::Vec3f;

TextTable TableOf(const std::vector<MotionCase>& cases) {
  TextTable table{{"case", "scene", "lidar", "motion", "per-ray poses", "map error mm", "p95 mm",
                   "beyond a voxel %", "completeness %"},
                  {true, true, true, true, true, false, false, false, false},
                  {},
                  {}};
  for (const MotionCase& c : cases) {
    table.rules_before.push_back(table.rows.size());
    for (const MotionError* error : {&c.off, &c.on}) {
      table.rows.push_back({c.name, c.scene, c.lidar, c.motion, error->motion_aware ? "on" : "off",
                            fmt::format("{:.1f}", 1e3 * error->mean_m),
                            fmt::format("{:.1f}", 1e3 * error->p95_m),
                            fmt::format("{:.1f}", 100.0 * error->beyond_voxel),
                            fmt::format("{:.1f}", 100.0 * error->completeness)});
    }
  }
  return table;
}

void AddDots(const std::vector<Vec3f>& points, const core::Box3& box, double left_px, double scale,
             double radius_px, const char* colour, std::string* svg) {
  *svg += fmt::format("<g fill=\"{}\">\n", colour);
  for (const Vec3f& p : points) {
    *svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>\n",
                        left_px + scale * (static_cast<double>(p.x()) - box.min.x()),
                        40.0 + scale * (box.max.y() - static_cast<double>(p.y())), radius_px);
  }
  *svg += "</g>\n";
}

/// The layer seen from above: truth grey, the map red; per-ray poses off on the left, on on the right.
std::string Picture(const MotionCase& c) {
  core::Box3 box;
  for (const std::vector<Vec3f>* points : {&c.off.slice, &c.on.slice}) {
    for (const Vec3f& p : *points) box.Extend(p.cast<double>());
  }
  if (box.Empty()) box.Extend(core::Vec3::Zero());
  box = box.Inflated(0.2);
  const double scale = 560.0 / std::max(box.Size().x(), box.Size().y());
  const double width = scale * box.Size().x(), height = scale * box.Size().y();
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0f}\" height=\"{:.0f}\" "
      "font-family=\"sans-serif\" "
      "font-size=\"15\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      2.0 * width + 60.0, height + 60.0);
  const std::pair<const MotionError*, double> halves[] = {{&c.off, 20.0}, {&c.on, width + 40.0}};
  for (const auto& [error, left] : halves) {
    svg += fmt::format("<text x=\"{:.0f}\" y=\"25\">per-ray poses {}: mean error {:.1f} mm</text>\n", left,
                       error->motion_aware ? "on" : "off", 1e3 * error->mean_m);
    std::vector<Vec3f> truth;
    for (const Vec3f& p : c.truth_slice) {
      if (p.x() > box.min.x() && p.x() < box.max.x() && p.y() > box.min.y() && p.y() < box.max.y())
        truth.push_back(p);
    }
    AddDots(truth, box, left, scale, 1.0, "#9aa0a6", &svg);
    AddDots(error->slice, box, left, scale, 1.3, "#d93025", &svg);
  }
  return svg + "</svg>\n";
}

}  // namespace

std::string MotionTable(const std::vector<MotionCase>& cases) {
  return ToTerminal(TableOf(cases)) +
         "map error: of mesh vertices to the nearest true surface; completeness: true surface that was hit, "
         "with a "
         "vertex within a voxel.\n";
}

void WriteMotionBench(const std::filesystem::path& folder, const std::vector<MotionCase>& cases) {
  core::WriteFileAtomically(folder / "motion.md", ToMarkdown(TableOf(cases)));
  core::WriteFileAtomically(folder / "motion.csv", ToCsv(TableOf(cases)));
  for (const MotionCase& c : cases)
    core::WriteFileAtomically(folder / ("motion_" + c.name + ".svg"), Picture(c));
}

}  // namespace atlas::experiments
