#include <fmt/format.h>

#include <numeric>

#include "core/files.h"
#include "experiments/bench/mapper_bench.h"
#include "experiments/report/text_table.h"
#include "experiments/results/statistics.h"
#include "experiments/results/svg_plot.h"

namespace atlas::experiments {
namespace {

double MeanOver(const std::vector<double>& values, size_t count) {
  const size_t n = std::min(count, values.size());
  return n == 0 ? 0.0
                : std::accumulate(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n), 0.0) /
                      static_cast<double>(n);
}

std::string Megabytes(size_t bytes) {
  return fmt::format("{:.1f}", static_cast<double>(bytes) / 1e6);
}

std::string Percent(double share) {
  return share < 0.0 ? "-" : fmt::format("{:.1f}", 100.0 * share);
}

std::vector<std::string> SettingCells(const MapperCaseResult& result) {
  return {result.setting.scene,
          fmt::format("{:.0f} m/{:.1f} cm", result.setting.max_range_m, 100.0 * result.setting.resolution_m)};
}

TextTable Speed(const std::vector<MapperCaseResult>& results) {
  TextTable table{{"scans of", "range/voxel", "mapper", "scans", "CPU ms", "p95", "wall ms", "common",
                   "x OctoMap", "MB common", "OctoMap / it", "MB at end", "RSS MB"},
                  {true, true, true},
                  {},
                  {}};
  table.left.resize(table.heading.size(), false);
  for (const MapperCaseResult& result : results) {
    table.rules_before.push_back(table.rows.size());
    const size_t common = result.common_scans;
    const bool octomap = result.courses[0].mapper == "OctoMap";
    for (const MapperCourse& course : result.courses) {
      std::vector<std::string> row = SettingCells(result);
      const double peer_ms = MeanOver(result.courses[0].cpu_ms, common);
      const double ms = MeanOver(course.cpu_ms, common);
      const size_t bytes = course.map_bytes[std::min(common, course.map_bytes.size()) - 1];
      const size_t peer_bytes = result.courses[0].map_bytes[common - 1];
      row.insert(
          row.end(),
          {course.mapper, fmt::format("{}", course.cpu_ms.size()),
           fmt::format("{:.1f}", MeanOver(course.cpu_ms, course.cpu_ms.size())),
           fmt::format("{:.1f}", Percentile(course.cpu_ms, 0.95)),
           fmt::format("{:.1f}", MeanOver(course.wall_ms, course.wall_ms.size())), fmt::format("{}", common),
           octomap ? fmt::format("{:.1f}", peer_ms / ms) : "-", Megabytes(bytes),
           octomap ? fmt::format("{:.1f}", static_cast<double>(peer_bytes) / static_cast<double>(bytes))
                   : "-",
           Megabytes(course.map_bytes.back()), Megabytes(course.resident_growth_bytes)});
      table.rows.push_back(row);
    }
  }
  return table;
}

TextTable Quality(const std::vector<MapperCaseResult>& results) {
  TextTable table{{"scans of", "range/voxel", "mapper", "after", "free on rays", "exact", "empty",
                   "hit occupied", "between 0-10", "10-30", "30-60", "0-30 m", "exact", "empty",
                   "surface freed", "grazing", "other", "obstacle freed"},
                  {true, true, true},
                  {},
                  {}};
  table.left.resize(table.heading.size(), false);
  const auto add = [&](const MapperCaseResult& result, const MapperCourse& course, size_t scans,
                       const MapQuality& q) {
    std::vector<std::string> row = SettingCells(result);
    row.insert(
        row.end(),
        {course.mapper, fmt::format("{}", scans), Percent(q.free_on_rays), Percent(q.free_on_rays_exact),
         Percent(q.free_on_rays_empty), Percent(q.occupied_near_hit), Percent(q.free_between_near),
         Percent(q.free_between_mid), Percent(q.free_between_far), Percent(q.free_between_30),
         Percent(q.free_between_30_exact), Percent(q.free_between_30_empty), Percent(q.surface_freed),
         Percent(q.surface_freed_grazing), Percent(q.surface_freed_other),
         q.obstacle_freed < 0.0 ? "-" : fmt::format("{:.2f}", 100.0 * q.obstacle_freed)});
    table.rows.push_back(row);
  };
  for (const MapperCaseResult& result : results) {
    table.rules_before.push_back(table.rows.size());
    for (const MapperCourse& course : result.courses) {
      add(result, course, std::min(result.common_scans, course.cpu_ms.size()),
          course.cpu_ms.size() > result.common_scans ? course.early : course.final);
    }
    for (const MapperCourse& course : result.courses) {
      if (course.cpu_ms.size() > result.common_scans) add(result, course, course.cpu_ms.size(), course.final);
    }
  }
  return table;
}

template <typename T>
std::vector<PlotSeries> CurvesOf(const MapperCaseResult& result, std::vector<T> MapperCourse::*values,
                                 double scale) {
  std::vector<PlotSeries> series;
  for (const MapperCourse& course : result.courses) {
    PlotSeries curve{.label = course.mapper, .markers = false};
    for (size_t i = 0; i < (course.*values).size(); ++i) {
      curve.x.push_back(static_cast<double>(i + 1));
      curve.y.push_back(scale * static_cast<double>((course.*values)[i]));
    }
    series.push_back(curve);
  }
  return series;
}

}  // namespace

std::string SpeedTable(const std::vector<MapperCaseResult>& results) {
  return ToTerminal(Speed(results)) +
         "common: scans that every mapper took (OctoMap stops early where it is hopeless); x OctoMap and "
         "sizes over "
         "those.\n";
}

std::string QualityTable(const std::vector<MapperCaseResult>& results) {
  return ToTerminal(Quality(results)) +
         "Per cent. free on rays, hit occupied: along beams. between: truly visible points off the beams "
         "held free (empty: those in voxels without surface; exact: of a map that holds just these free). "
         "surface freed:\ntrue surface in view held free (grazing: beyond 80 degrees). obstacle freed: of "
         "surface wider "
         "than the beams' spacing, freed with nothing occupied near.\n";
}

void WriteMapperBench(const std::filesystem::path& folder, const std::vector<MapperCaseResult>& results) {
  std::string csv = "scene,max_range_m,resolution_m,mapper,scan,cpu_ms,wall_ms,map_bytes\n";
  for (const MapperCaseResult& result : results) {
    const MapperCase& setting = result.setting;
    for (const MapperCourse& course : result.courses) {
      for (size_t i = 0; i < course.cpu_ms.size(); ++i) {
        csv += fmt::format("{},{},{},{},{},{:.4f},{:.4f},{}\n", setting.scene, setting.max_range_m,
                           setting.resolution_m, course.mapper, i + 1, course.cpu_ms[i], course.wall_ms[i],
                           course.map_bytes[i]);
      }
    }
    const std::string stem =
        fmt::format("{}_{:.0f}m_{:.1f}cm", setting.scene, setting.max_range_m, 100.0 * setting.resolution_m);
    PlotOptions plot;
    plot.title = fmt::format("{}, {:.0f} m, {:.1f} cm", setting.scene, setting.max_range_m,
                             100.0 * setting.resolution_m);
    plot.x_label = "scan";
    plot.integer_x = true;
    plot.y_label = "CPU ms";
    core::WriteFileAtomically(folder / (stem + "_time.svg"),
                              PlotSvg(CurvesOf(result, &MapperCourse::cpu_ms, 1.0), plot));
    plot.y_label = "map, MB";
    core::WriteFileAtomically(folder / (stem + "_memory.svg"),
                              PlotSvg(CurvesOf(result, &MapperCourse::map_bytes, 1e-6), plot));
  }
  core::WriteFileAtomically(folder / "mapper_bench.csv", csv);
  core::WriteFileAtomically(folder / "speed.md", ToMarkdown(Speed(results)));
  core::WriteFileAtomically(folder / "quality.md", ToMarkdown(Quality(results)));
}

}  // namespace atlas::experiments
