#include "mapping/slam/room_graph.h"

#include <cmath>

namespace atlas::mapping {
namespace {

/// The way: laps round a corridor of 60 x 40 m; at every second step of 20 m into a room of 6 m depth and
/// back, so that laps see the same rooms. Even laps go the other way round. In space, the floor swings by 1
/// m.
std::vector<core::Pose> WayThroughRooms(uint32_t nodes, bool planar) {
  std::vector<core::Vec3> corners;
  const auto side = [&](core::Vec3 from, const core::Vec3& to) {
    const core::Vec3 along = (to - from).normalized(), into(along.y(), -along.x(), 0.0);
    for (double s = 0.0; s + 20.0 <= (to - from).norm() + 1e-9; s += 20.0) {
      const core::Vec3 door = from + (s + 10.0) * along;
      corners.insert(corners.end(), {from + s * along, door, door + 6.0 * into, door});
    }
  };
  const core::Vec3 a(0, 0, 0), b(60, 0, 0), c(60, 40, 0), d(0, 40, 0);
  side(a, b);
  side(b, c);
  side(c, d);
  side(d, a);
  std::vector<core::Pose> way;
  core::Vec3 p = corners.front();
  for (size_t lap = 0; way.size() < nodes; ++lap) {
    std::vector<core::Vec3> targets(corners.begin() + 1, corners.end());
    targets.push_back(corners.front());
    if (lap % 2 == 1) targets.assign(corners.rbegin(), corners.rend());
    for (const core::Vec3& target : targets) {
      const core::Vec3 step = target - p;
      const int steps = static_cast<int>(std::lround(step.norm() / 2.0));
      for (int k = 0; k < steps && way.size() < nodes; ++k) {
        core::Vec3 at = p + step * (k / static_cast<double>(steps));
        if (!planar) at.z() = std::sin(at.x() / 9.0);
        way.push_back(
            core::MakePose(core::RotationFromYawPitchRoll(std::atan2(step.y(), step.x()),
                                                          planar ? 0.0 : 0.05 * std::cos(at.y()), 0.0),
                           at));
      }
      p = target;
    }
  }
  return way;
}

}  // namespace

core::Vec6 DrawError(const EdgeNoise& noise, bool planar, core::Rng* rng) {
  core::Vec6 xi;
  for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? noise.sigma_m : noise.sigma_rad) * rng->Normal();
  if (planar) xi[2] = xi[3] = xi[4] = 0.0;
  return xi;
}

PoseEdge MeasuredEdge(const RoomGraph& rooms, uint32_t from, uint32_t to, const EdgeNoise& noise,
                      core::Rng* rng) {
  PoseEdge edge{.from = from, .to = to};
  edge.T_from_to =
      rooms.T_true[from].inverse() * rooms.T_true[to] * core::Exp(DrawError(noise, rooms.graph.planar, rng));
  const double w_t = 1.0 / (noise.sigma_m * noise.sigma_m), w_r = 1.0 / (noise.sigma_rad * noise.sigma_rad);
  edge.information.diagonal() << w_t, w_t, w_t, w_r, w_r, w_r;
  return edge;
}

RoomGraph MakeRoomGraph(uint32_t nodes, uint32_t loop_every, core::Rng rng, bool planar) {
  RoomGraph rooms;
  rooms.graph.planar = planar;
  rooms.T_true = WayThroughRooms(nodes, planar);
  rooms.graph.T_map_node = {rooms.T_true.front()};
  core::Rng odometry = rng.Split("odometry"), loops = rng.Split("loops");
  for (uint32_t node = 1; node < nodes; ++node) {
    rooms.graph.edges.push_back(MeasuredEdge(rooms, node - 1, node, {}, &odometry));
    rooms.graph.T_map_node.push_back(rooms.graph.T_map_node.back() * rooms.graph.edges.back().T_from_to);
  }
  for (uint32_t to = 100; to < nodes; to += loop_every) {
    for (uint32_t from = 0; from + 100 < to; ++from) {
      if ((rooms.T_true[from].translation() - rooms.T_true[to].translation()).norm() > 1.5) continue;
      rooms.graph.edges.push_back(MeasuredEdge(rooms, from, to, {0.03, core::Radians(0.3)}, &loops));
      rooms.graph.edges.back().kind = EdgeKind::kLoop;
      break;
    }
  }
  return rooms;
}

}  // namespace atlas::mapping
