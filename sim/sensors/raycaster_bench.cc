#include "sim/sensors/raycaster_bench.h"

#include <ctime>

#include "sim/sensors/embree.h"
#include "sim/sensors/lidar.h"
#include "sim/sensors/raycaster.h"

namespace atlas::sim {
namespace {

constexpr int kPoses = 8;
constexpr double kSensorHeightM = 0.8;
constexpr double kRollRad = core::Radians(40.0);

double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Items a second of `round`, which handles `items`.
template <typename Round>
double Rate(size_t items, double seconds, const Round& round) {
  round();  // warms caches
  const double start = ThreadCpuSeconds();
  size_t rounds = 0;
  double elapsed = 0.0;
  do {
    round();
    ++rounds;
    elapsed = ThreadCpuSeconds() - start;
  } while (elapsed < seconds);
  return static_cast<double>(rounds * items) / elapsed;
}

/// Poses on a ring 3 m outside the object, facing it, rolled evenly from one side to the other.
std::vector<core::Pose> RingOfPoses(const scenes::SceneSpec& scene) {
  const core::Vec3 center = scene.object_box.Empty() ? core::Vec3(0, 0, 0) : scene.object_box.Center();
  const core::Vec3 half =
      scene.object_box.Empty() ? core::Vec3(0, 0, 0) : core::Vec3(0.5 * scene.object_box.Size());
  const double radius = std::max(half.x(), half.y()) + 3.0;
  std::vector<core::Pose> poses;
  for (int i = 0; i < kPoses; ++i) {
    const double bearing = 2.0 * core::kPi * i / kPoses;
    const double roll = kRollRad * (2.0 * i / (kPoses - 1) - 1.0);
    poses.push_back(core::MakePose(core::RotationFromYawPitchRoll(bearing + core::kPi, 0.0, roll),
                                   core::Vec3(center.x() + radius * std::cos(bearing),
                                              center.y() + radius * std::sin(bearing), kSensorHeightM)));
  }
  return poses;
}

std::vector<core::Ray> RaysOf(const core::LidarModel& model, const std::vector<core::Pose>& poses) {
  Raycaster nothing{scenes::SceneSpec{}};
  Lidar lidar(model, core::Rng(1));
  core::PoseTrajectory still;
  still.Add(0.0, core::Pose::Identity());
  const core::LidarScan scan = lidar.Spin(&nothing, 0.0, still, nullptr, 1);
  std::vector<core::Ray> rays;
  for (const core::Pose& T_map_lidar : poses) {
    const Eigen::Isometry3f T = T_map_lidar.cast<float>();
    for (const core::Vec3f& d : scan.direction_lidar) rays.push_back({T.translation(), T.linear() * d});
  }
  return rays;
}

core::TriMesh BoxMesh(const core::Vec3f& half) {
  core::TriMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(),
                               (i & 4 ? 1 : -1) * half.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A trunk below the sensor and four legs of four links.
void AddRobot(Raycaster* raycaster) {
  raycaster->AddBody(BoxMesh({0.35f, 0.2f, 0.12f}));
  for (int i = 0; i < 16; ++i) raycaster->AddBody(BoxMesh({0.04f, 0.04f, 0.12f}));
}

void PoseRobot(Raycaster* raycaster, const core::Pose& T_map_lidar) {
  const auto place = [&](int body, double x, double y, double z) {
    raycaster->SetBodyPose(body, T_map_lidar * Eigen::Translation3d(x, y, z));
  };
  place(0, 0.0, 0.0, -0.3);
  for (int i = 0; i < 16; ++i) place(1 + i, i & 1 ? 0.3 : -0.3, i & 2 ? 0.25 : -0.25, -0.3 - 0.12 * (i / 4));
  raycaster->CommitPoses();
}

/// Embree with nothing around it: one geometry, rays packed before the clock starts.
class BareEmbree {
 public:
  explicit BareEmbree(const scenes::SceneSpec& spec) {
    core::TriMesh all;
    for (const scenes::ScenePart& part : spec.parts) all.Append(part.mesh);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertex = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                           all.vertices.size());
    std::copy_n(reinterpret_cast<const float*>(all.vertices.data()), 3 * all.vertices.size(),
                static_cast<float*>(vertex));
    void* index = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                          all.triangles.size());
    std::copy(all.triangles.begin(), all.triangles.end(), static_cast<std::array<uint32_t, 3>*>(index));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~BareEmbree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareEmbree(const BareEmbree&) = delete;

  double BestRate(const std::vector<core::Ray>& rays, float max_range_m, double seconds) {
    Pack(rays, max_range_m);
    const size_t n = rays.size();
    CoherentQuery::Context context;
    CoherentQuery query(&context);
    alignas(64) int valid[16];
    std::fill(std::begin(valid), std::end(valid), -1);
    const double packets = Rate(n, seconds, [&] {
      for (const RTCRayHit16& fresh : packed_) {
        RTCRayHit16 packet = fresh;
        query.CastPacket<rtcIntersect16>(valid, scene_, &packet);
        sink_ = packet.ray.tfar[0];
      }
    });
    const double single = Rate(n, seconds, [&] {
      for (const RTCRayHit& fresh : singles_) {
        RTCRayHit ray = fresh;
        query.CastRay(scene_, &ray);
        sink_ = ray.ray.tfar;
      }
    });
    std::vector<RTCRayHit> stream;
    const double streams = Rate(n, seconds, [&] {
      stream = singles_;
      query.CastStream(scene_, stream.data(), static_cast<unsigned int>(n));
    });
    return std::max({packets, single, streams});
  }

 private:
  void Pack(const std::vector<core::Ray>& rays, float max_range_m) {
    singles_.assign(rays.size(), RTCRayHit{});
    packed_.assign((rays.size() + 15) / 16, RTCRayHit16{});
    for (size_t i = 0; i < 16 * packed_.size(); ++i) {
      const core::Ray& r = rays[std::min(i, rays.size() - 1)];
      RTCRayHit16& p = packed_[i / 16];
      const size_t lane = i % 16;
      p.ray.org_x[lane] = r.origin.x(), p.ray.org_y[lane] = r.origin.y(), p.ray.org_z[lane] = r.origin.z();
      p.ray.dir_x[lane] = r.direction.x(), p.ray.dir_y[lane] = r.direction.y();
      p.ray.dir_z[lane] = r.direction.z(), p.ray.tfar[lane] = max_range_m, p.ray.mask[lane] = ~0u;
      p.hit.geomID[lane] = p.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
      if (i >= rays.size()) continue;
      RTCRayHit& s = singles_[i];
      s.ray.org_x = r.origin.x(), s.ray.org_y = r.origin.y(), s.ray.org_z = r.origin.z();
      s.ray.dir_x = r.direction.x(), s.ray.dir_y = r.direction.y(), s.ray.dir_z = r.direction.z();
      s.ray.tfar = max_range_m, s.ray.mask = ~0u;
      s.hit.geomID = s.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
  }

  RTCDevice device_ = rtcNewDevice("threads=1");
  RTCScene scene_ = rtcNewScene(device_);
  std::vector<RTCRayHit> singles_;
  std::vector<RTCRayHit16> packed_;
  volatile float sink_ = 0.0f;  ///< keeps the loops from being optimised away
};

}  // namespace

RaycasterSpeed MeasureRaycaster(const scenes::SceneSpec& scene, const core::LidarModel& model,
                                double seconds) {
  const std::vector<core::Pose> poses = RingOfPoses(scene);
  const std::vector<core::Ray> rays = RaysOf(model, poses);
  const size_t rays_a_pose = rays.size() / poses.size();
  const auto max_range_m = static_cast<float>(model.max_range_m);
  std::vector<RayHit> hits(rays.size());
  RaycasterSpeed speed;
  for (const scenes::ScenePart& part : scene.parts) speed.triangles += part.mesh.triangles.size();

  Raycaster raycaster(scene);
  const auto cast_all = [&](bool with_robot) {
    for (size_t p = 0; p < poses.size(); ++p) {
      if (with_robot) PoseRobot(&raycaster, poses[p]);
      raycaster.Cast(std::span(rays).subspan(p * rays_a_pose, rays_a_pose), max_range_m, 1, 1,
                     std::span(hits).subspan(p * rays_a_pose, rays_a_pose));
    }
  };
  speed.rays_per_second = Rate(rays.size(), seconds, [&] { cast_all(false); });
  AddRobot(&raycaster);
  speed.rays_per_second_with_robot = Rate(rays.size(), seconds, [&] { cast_all(true); });
  speed.bare_rays_per_second = BareEmbree(scene).BestRate(rays, max_range_m, seconds);

  Lidar lidar(model, core::Rng(1));
  core::PoseTrajectory walk;
  for (int i = 0; i <= 10; ++i) walk.Add(0.01 * i, poses[0] * Eigen::Translation3d(0.005 * i, 0.0, 0.0));
  const double spins_per_second = Rate(1, seconds, [&] {
    lidar.Spin(
        &raycaster, 0.0, walk, [&](double t) { PoseRobot(&raycaster, walk.At(t)); }, 1);
  });
  speed.spin_ms = 1e3 / spins_per_second;
  return speed;
}

}  // namespace atlas::sim
