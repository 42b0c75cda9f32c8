#include "sim/sensors/raycaster.h"

#include <cassert>
#include <stdexcept>

#include "core/parallel_for.h"
#include "core/rng.h"
#include "sim/sensors/body_mesh.h"
#include "sim/sensors/embree.h"

namespace atlas::sim {
namespace {

/// Rays are cast in groups of this many, whatever the packet width, so that no result depends on the threads.
constexpr size_t kGroup = 16;
/// Embree promises nothing for hits exactly at tfar: cast a little farther, then compare.
constexpr float kBeyond = 1.0001f;

template <int kWidth>
struct Packet;
template <>
struct Packet<4> {
  RTCRayHit4 data;
  void Intersect(const int* valid, RTCScene scene, CoherentQuery* query) {
    query->CastPacket<rtcIntersect4>(valid, scene, &data);
  }
};
template <>
struct Packet<8> {
  RTCRayHit8 data;
  void Intersect(const int* valid, RTCScene scene, CoherentQuery* query) {
    query->CastPacket<rtcIntersect8>(valid, scene, &data);
  }
};
template <>
struct Packet<16> {
  RTCRayHit16 data;
  void Intersect(const int* valid, RTCScene scene, CoherentQuery* query) {
    query->CastPacket<rtcIntersect16>(valid, scene, &data);
  }
};

/// What the transmission filter needs to know of a cast; Embree hands the first member back to it.
struct CastContext {
  CoherentQuery::Context embree;
  uint64_t seed;
};

/// A partly transmissive part; the user data of its geometry.
struct Screen {
  int32_t part;
  double transmission;
};

/// Rejects the hits of the rays that pass. One draw for a ray and a part, so that a ray that passes a part's
/// front face passes its back face too.
void PassThroughScreen(const RTCFilterFunctionNArguments* args) {
  const auto& screen = *static_cast<const Screen*>(args->geometryUserPtr);
  const uint64_t seed = reinterpret_cast<const CastContext*>(args->context)->seed;
  const uint64_t stream = core::HashCounter(seed, static_cast<uint64_t>(screen.part));
  for (unsigned int lane = 0; lane < args->N; ++lane) {
    if (args->valid[lane] == 0) continue;
    const unsigned int ray = RTCRayN_id(args->ray, args->N, lane);
    if (core::UniformAt(stream, ray) < screen.transmission) args->valid[lane] = 0;
  }
}

/// Fills the packet's lanes; those from `count` on repeat the last ray (they are not valid).
template <int kWidth>
void Load(const core::Ray* rays, size_t count, size_t first_id, float tfar, Packet<kWidth>* packet) {
  auto& ray = packet->data.ray;
  auto& hit = packet->data.hit;
  for (int lane = 0; lane < kWidth; ++lane) {
    ray.tfar[lane] = tfar;
    ray.id[lane] = static_cast<unsigned int>(first_id) + static_cast<unsigned int>(lane);
    hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
  for (size_t lane = 0; lane < kWidth; ++lane) {
    const core::Ray& r = rays[std::min(lane, count - 1)];
    ray.org_x[lane] = r.origin.x();
    ray.org_y[lane] = r.origin.y();
    ray.org_z[lane] = r.origin.z();
    ray.dir_x[lane] = r.direction.x();
    ray.dir_y[lane] = r.direction.y();
    ray.dir_z[lane] = r.direction.z();
  }
}

void FillGeometry(RTCGeometry geometry, const std::vector<const core::TriMesh*>& meshes) {
  size_t vertices = 0, triangles = 0;
  for (const core::TriMesh* mesh : meshes) {
    vertices += mesh->vertices.size();
    triangles += mesh->triangles.size();
  }
  auto* vertex = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices));
  auto* index = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles));
  uint32_t base = 0;
  for (const core::TriMesh* mesh : meshes) {
    for (const core::Vec3f& v : mesh->vertices) {
      for (int axis = 0; axis < 3; ++axis) *vertex++ = v[axis];
    }
    for (const auto& t : mesh->triangles) {
      for (const uint32_t corner : t) *index++ = base + corner;
    }
    base += static_cast<uint32_t>(mesh->vertices.size());
  }
}

/// A committed scene that holds one triangle geometry.
RTCScene MakeBodyScene(RTCDevice device, const core::TriMesh& mesh) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  FillGeometry(geometry, {&mesh});
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

struct Raycaster::Impl {
  /// One thread builds: trees, and with them the choice between hits at equal range, repeat.
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene static_scene = nullptr;
  RTCScene opaque_scene = nullptr;  ///< as static_scene without filters; the same one where no part transmits
  RTCScene body_scene = nullptr;
  std::vector<int32_t> part_of_triangle;         ///< of geometry 0, which holds all opaque parts
  std::vector<std::unique_ptr<Screen>> screens;  ///< geometries 1, 2, ...
  std::vector<BodyMesh> bodies;
  std::vector<RTCGeometry> instances;
  bool poses_changed = false;
  int width = 4;

  ~Impl() {
    if (opaque_scene != static_scene) rtcReleaseScene(opaque_scene);
    rtcReleaseScene(static_scene);
    rtcReleaseScene(body_scene);
    rtcReleaseDevice(device);
  }

  RTCScene BuildStatic(const scenes::SceneSpec& spec, bool filtered);
  template <int kWidth>
  void CastGroups(RTCScene scene, bool with_bodies, std::span<const core::Ray> rays, size_t first,
                  size_t last, float max_range_m, uint64_t seed, std::span<RayHit> hits) const;
  void CastAll(RTCScene scene, bool with_bodies, std::span<const core::Ray> rays, float max_range_m,
               uint64_t seed, int threads, std::span<RayHit> hits) const;
  template <int kWidth>
  RayHit Unload(const Packet<kWidth>& packet, size_t lane, float max_range_m) const {
    const auto& hit = packet.data.hit;
    const uint32_t geometry = hit.geomID[lane], body = hit.instID[0][lane];
    const float range_m = packet.data.ray.tfar[lane];
    if (geometry == RTC_INVALID_GEOMETRY_ID || range_m > max_range_m) return {};
    const int32_t part = body != RTC_INVALID_GEOMETRY_ID ? kMovingBody + static_cast<int32_t>(body)
                         : geometry == 0                 ? part_of_triangle[hit.primID[lane]]
                                                         : screens[geometry - 1]->part;
    return {range_m, part, {hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]}};
  }
};

RTCScene Raycaster::Impl::BuildStatic(const scenes::SceneSpec& spec, bool filtered) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  std::vector<const core::TriMesh*> opaque;
  for (const scenes::ScenePart& part : spec.parts) {
    if (part.ray_transmission <= 0.0) opaque.push_back(&part.mesh);
  }
  const auto attach = [&](const std::vector<const core::TriMesh*>& meshes, Screen* screen, unsigned int id) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    FillGeometry(geometry, meshes);
    if (screen != nullptr && filtered) {
      rtcSetGeometryUserData(geometry, screen);
      rtcSetGeometryIntersectFilterFunction(geometry, PassThroughScreen);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
  };
  attach(opaque, nullptr, 0);
  for (size_t i = 0; i < screens.size(); ++i) {
    attach({&spec.parts[static_cast<size_t>(screens[i]->part)].mesh}, screens[i].get(),
           static_cast<unsigned int>(i + 1));
  }
  rtcCommitScene(scene);
  return scene;
}

template <int kWidth>
void Raycaster::Impl::CastGroups(RTCScene scene, bool with_bodies, std::span<const core::Ray> rays,
                                 size_t first, size_t last, float max_range_m, uint64_t seed,
                                 std::span<RayHit> hits) const {
  Packet<kWidth> packet = {};
  alignas(64) int valid[kWidth];
  std::fill_n(valid, kWidth, -1);
  std::fill_n(packet.data.ray.mask, kWidth, ~0u);
  CastContext context{{}, seed};
  CoherentQuery query(&context.embree);
  size_t base = first;
  const auto cast = [&](size_t count) {
    Load<kWidth>(rays.data() + base, count, base, max_range_m * kBeyond, &packet);
    packet.Intersect(valid, scene, &query);
    // A body that is nearer overwrites the hit; one that is not leaves it alone.
    if (with_bodies) packet.Intersect(valid, body_scene, &query);
    for (size_t lane = 0; lane < count; ++lane) hits[base + lane] = Unload(packet, lane, max_range_m);
  };
  for (; base + kWidth <= last; base += kWidth) cast(kWidth);
  if (base == last) return;
  std::fill(valid + (last - base), valid + kWidth, 0);
  cast(last - base);
}

void Raycaster::Impl::CastAll(RTCScene scene, bool with_bodies, std::span<const core::Ray> rays,
                              float max_range_m, uint64_t seed, int threads, std::span<RayHit> hits) const {
  assert(hits.size() >= rays.size());
  const size_t groups = (rays.size() + kGroup - 1) / kGroup;
  core::ParallelFor(threads, groups, [&](size_t begin, size_t end, size_t) {
    const size_t first = begin * kGroup, last = std::min(end * kGroup, rays.size());
    switch (width) {
      case 16:
        return CastGroups<16>(scene, with_bodies, rays, first, last, max_range_m, seed, hits);
      case 8:
        return CastGroups<8>(scene, with_bodies, rays, first, last, max_range_m, seed, hits);
      default:
        return CastGroups<4>(scene, with_bodies, rays, first, last, max_range_m, seed, hits);
    }
  });
}

Raycaster::Raycaster(const scenes::SceneSpec& scene) : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  if (m.device == nullptr) throw std::runtime_error("Embree cannot start on this machine");
  if (rtcGetDeviceProperty(m.device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0) m.width = 8;
  if (rtcGetDeviceProperty(m.device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) m.width = 16;
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    const scenes::ScenePart& part = scene.parts[i];
    const auto id = static_cast<int32_t>(i);
    if (part.ray_transmission > 0.0) {
      m.screens.push_back(std::make_unique<Screen>(Screen{id, part.ray_transmission}));
    } else {
      m.part_of_triangle.insert(m.part_of_triangle.end(), part.mesh.triangles.size(), id);
    }
  }
  m.static_scene = m.BuildStatic(scene, true);
  m.opaque_scene = m.screens.empty() ? m.static_scene : m.BuildStatic(scene, false);
  m.body_scene = rtcNewScene(m.device);
  rtcSetSceneFlags(m.body_scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
  rtcSetSceneBuildQuality(m.body_scene, RTC_BUILD_QUALITY_LOW);
  rtcCommitScene(m.body_scene);
}

Raycaster::~Raycaster() = default;
Raycaster::Raycaster(Raycaster&&) noexcept = default;

int Raycaster::AddBody(const core::TriMesh& mesh_body) {
  Impl& m = *impl_;
  const auto body = static_cast<int>(m.bodies.size());
  RTCScene scene = MakeBodyScene(m.device, mesh_body);
  RTCGeometry instance = rtcNewGeometry(m.device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, scene);
  rtcAttachGeometryByID(m.body_scene, instance, static_cast<unsigned int>(body));
  rtcReleaseGeometry(instance);  // the scene holds it
  rtcReleaseScene(scene);
  m.bodies.emplace_back(mesh_body);
  m.instances.push_back(instance);
  SetBodyPose(body, core::Pose::Identity());
  return body;
}

void Raycaster::SetBodyPose(int body, const core::Pose& T_map_body) {
  Impl& m = *impl_;
  const auto i = static_cast<size_t>(body);
  assert(i < m.bodies.size());
  m.bodies[i].SetPose(T_map_body);
  const Eigen::Matrix<float, 3, 4> T = T_map_body.matrix().topRows<3>().cast<float>();  // column-major
  rtcSetGeometryTransform(m.instances[i], 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, T.data());
  rtcCommitGeometry(m.instances[i]);
  m.poses_changed = true;
}

void Raycaster::CommitPoses() {
  if (!impl_->poses_changed) return;
  rtcCommitScene(impl_->body_scene);
  impl_->poses_changed = false;
}

bool Raycaster::NearBody(const core::Vec3& p_map, double margin_m) const {
  return std::any_of(impl_->bodies.begin(), impl_->bodies.end(),
                     [&](const BodyMesh& body) { return body.IsWithin(p_map, margin_m); });
}

double Raycaster::BodyReach(const core::Vec3& p_map) const {
  double reach = 0.0;
  for (const BodyMesh& body : impl_->bodies) reach = std::max(reach, body.Reach(p_map));
  return reach;
}

void Raycaster::Cast(std::span<const core::Ray> rays, float max_range_m, uint64_t transmission_seed,
                     int threads, std::span<RayHit> hits) const {
  assert(!impl_->poses_changed);
  impl_->CastAll(impl_->static_scene, !impl_->bodies.empty(), rays, max_range_m, transmission_seed, threads,
                 hits);
}

void Raycaster::CastStatic(std::span<const core::Ray> rays, float max_range_m, int threads,
                           std::span<RayHit> hits) const {
  impl_->CastAll(impl_->opaque_scene, false, rays, max_range_m, 0, threads, hits);
}

}  // namespace atlas::sim
