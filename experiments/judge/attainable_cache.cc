#include "experiments/judge/attainable_cache.h"

#include <cstring>
#include <string>

#include "core/errors.h"
#include "core/files.h"
#include "core/fingerprint.h"

namespace atlas::experiments {
namespace {

constexpr uint64_t kMagic = 0x316e69617474411aull;  // changes with the meaning of the file or of the method
constexpr uint64_t kMethod = 5;

struct Header {
  uint64_t magic, key, points, positions, rays;
  double reachable_area_m2;
  uint64_t checksum;  // of the fields above and the bits
};

uint64_t ChecksumOf(const Header& header, const std::string& bits) {
  core::Fingerprint print;
  print.Bytes(&header, offsetof(Header, checksum));
  print.Bytes(bits.data(), bits.size());
  return print.value();
}

std::string Pack(const std::vector<uint8_t>& flags) {
  std::string bits((flags.size() + 7) / 8, '\0');
  for (size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0) bits[i / 8] = static_cast<char>(bits[i / 8] | (1 << (i % 8)));
  }
  return bits;
}

}  // namespace

uint64_t AttainableKey(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth,
                       const robots::RobotSpec& robot, const core::LidarModel& lidar,
                       const AttainableOptions& options) {
  core::Fingerprint print;
  const auto pose = [&print](const core::Pose& T) { print.Bytes(T.matrix().data(), 16 * sizeof(double)); };
  const auto numbers = [&print](const auto& values) {
    print.Bytes(values.data(), values.size() * sizeof(values[0]));
  };
  print.Value(kMethod);
  for (const scenes::ScenePart& part : scene.parts) {
    numbers(part.mesh.vertices);
    numbers(part.mesh.triangles);
    print.Value(part.ray_transmission);
  }
  pose(scene.T_map_spawn);
  for (const core::Box3* box : {&scene.object_box, &scene.bounds}) {
    print.Bytes(box->min.data(), 3 * sizeof(double));
    print.Bytes(box->max.data(), 3 * sizeof(double));
  }
  numbers(truth.points);
  numbers(truth.normals);
  numbers(truth.two_sided);
  pose(robot.T_base_lidar);
  for (const double v : {robot.stance_height_m, robot.footprint_radius_m, robot.half_width_m,
                         robot.body_top_m, robot.max_step_m}) {
    print.Value(v);
  }
  numbers(lidar.elevation_rad);
  print.Value(lidar.columns);
  for (const double v : {lidar.spin_rate_hz, lidar.min_range_m, lidar.max_range_m}) print.Value(v);
  for (const double v : {options.radius_m, options.lattice_m, options.max_range_m, options.sweep_roll_deg,
                         options.sweep_period_s, options.target_spacing_m, options.min_rays,
                         options.reach.cell_m, options.reach.slope_span_m}) {
    print.Value(v);
  }
  print.Value(options.headings);
  return print.value();
}

std::optional<Attainable> ReadAttainable(const std::filesystem::path& path, uint64_t key,
                                         size_t truth_points) {
  std::string content;
  try {
    content = core::ReadFile(path);
  } catch (const core::InputError&) {
    return std::nullopt;
  }
  Header header;
  if (content.size() != sizeof(header) + (truth_points + 7) / 8) return std::nullopt;
  std::memcpy(&header, content.data(), sizeof(header));
  const std::string bits = content.substr(sizeof(header));
  if (header.magic != kMagic || header.key != key || header.points != truth_points) return std::nullopt;
  if (header.checksum != ChecksumOf(header, bits)) return std::nullopt;

  Attainable set;
  set.positions = header.positions;
  set.rays = header.rays;
  set.reachable_area_m2 = header.reachable_area_m2;
  set.from_cache = true;
  set.attainable.resize(truth_points);
  size_t count = 0;
  for (size_t i = 0; i < truth_points; ++i) {
    set.attainable[i] = (static_cast<unsigned char>(bits[i / 8]) >> (i % 8)) & 1;
    count += set.attainable[i];
  }
  set.coverage = truth_points > 0 ? static_cast<double>(count) / static_cast<double>(truth_points) : 0.0;
  return set;
}

void WriteAttainable(const std::filesystem::path& path, uint64_t key, const Attainable& set) {
  const std::string bits = Pack(set.attainable);
  Header header{kMagic, key, set.attainable.size(), set.positions, set.rays, set.reachable_area_m2, 0};
  header.checksum = ChecksumOf(header, bits);
  std::string content(sizeof(header), '\0');
  std::memcpy(content.data(), &header, sizeof(header));
  core::WriteFileAtomically(path, content + bits);
}

}  // namespace atlas::experiments
