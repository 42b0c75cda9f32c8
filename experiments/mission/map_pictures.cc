#include "experiments/mission/map_pictures.h"

#include <fmt/format.h>

#include <map>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/video/atlas_picture.h"
#include "experiments/video/video_writer.h"
#include "planner/views/map_ground.h"

namespace atlas::experiments {
namespace {

constexpr int kPlanIterations = 12000;
constexpr double kBodyMarginM = 0.07;

AtlasDrawing DrawingOf(const Mission& mission, const mapping::MapView& view) {
  AtlasDrawing drawing;
  drawing.map = &view;
  drawing.box_map = mission.scene.object_box;
  drawing.loops = mission.localiser->poses()->Loops();
  const auto poses = mission.localiser->poses();
  std::map<core::KeyframeId, uint32_t> submap_of;
  for (const mapping::SubmapMembers& members : mission.map->Submaps()) {
    for (const core::KeyframeId keyframe : members.keyframes) submap_of[keyframe] = members.id;
  }
  for (core::KeyframeId k = 0; k <= poses->latest(); ++k) {
    drawing.nodes.push_back(poses->T_map_keyframe(k).translation());
    drawing.submap.push_back(submap_of.contains(k) ? submap_of[k] : 0);
  }
  return drawing;
}

void WritePicture(Mission* mission, const AtlasDrawing& drawing, const char* file) {
  try {
    WritePng(mission->options.folder / file, AtlasPicture(drawing));
  } catch (const core::InputError& error) {
    mission->metrics.Note(fmt::format("no {}: {}", file, error.what()));
  }
}

std::string WayCsv(const std::vector<core::Vec3>& way) {
  std::string csv = "x_m,y_m,z_m\n";
  for (const core::Vec3& p : way) csv += fmt::format("{:.4f},{:.4f},{:.4f}\n", p.x(), p.y(), p.z());
  return csv;
}

/// A way between the places of mission.plan_after.
void PlanAfter(Mission* mission, const mapping::MapView& view, AtlasDrawing drawing) {
  const auto places = PlanAfterOf(mission->config.mission);
  if (!places) return;
  const planner::MapGround ground(view, {.radius_m = mission->robot.half_width_m + kBodyMarginM});
  const auto way = planner::PlanOnMap(ground, mission->scene.object_box, places->first, places->second,
                                      kPlanIterations, mission->rng.Split("plan_after"));
  mission->metrics.ObservePlannedWay(way ? std::optional(way->length_m) : std::nullopt);
  if (!way) {
    mission->metrics.Note("plan_after: no way found on the map");
    return;
  }
  drawing.way = way->points;
  drawing.loops.clear();
  core::WriteFileAtomically(mission->options.folder / "planned_way.csv", WayCsv(way->points));
  WritePicture(mission, drawing, "planned_way.png");
}

core::Vec3 PlaceOf(const std::string& text) {
  std::istringstream in(text);
  core::Vec3 p;
  if (!(in >> p.x() >> p.y() >> p.z()) || !p.allFinite() || !(in >> std::ws).eof()) {
    throw core::InputError(fmt::format("mission.plan_after: '{}' is not \"X Y Z\" (m)", text));
  }
  return p;
}

}  // namespace

std::optional<std::pair<core::Vec3, core::Vec3>> PlanAfterOf(const MissionParams& params) {
  if (params.plan_after.empty()) return std::nullopt;
  if (params.plan_after.size() != 2) {
    throw core::InputError(
        fmt::format("mission.plan_after: {} places; a way has two ends", params.plan_after.size()));
  }
  return std::pair(PlaceOf(params.plan_after[0]), PlaceOf(params.plan_after[1]));
}

void FinishWithPictures(Mission* mission) {
  const bool elastic = !mission->map->Submaps().empty();
  if (!elastic && mission->config.mission.plan_after.empty()) return;
  const auto view = mission->map->Snapshot();
  const AtlasDrawing drawing = DrawingOf(*mission, *view);
  if (elastic) WritePicture(mission, drawing, "submaps.png");
  PlanAfter(mission, *view, drawing);
}

}  // namespace atlas::experiments
