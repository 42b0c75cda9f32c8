// Embree 3 and 4 under one set of names. They differ in the argument that carries a query's context and
// flags.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace atlas::sim {

/// Intersection queries of coherent rays.
class CoherentQuery {
 public:
#if RTC_VERSION_MAJOR >= 4
  using Context = RTCRayQueryContext;
  /// @pre `context`, which filter functions are handed, outlives the queries.
  explicit CoherentQuery(Context* context) {
    rtcInitRayQueryContext(context);
    rtcInitIntersectArguments(&arguments_);
    arguments_.context = context;
    arguments_.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  }
  /// kIntersect: rtcIntersect4, 8 or 16, matching the packet.
  template <auto kIntersect, typename Packet>
  void CastPacket(const int* valid, RTCScene scene, Packet* packet) {
    kIntersect(valid, scene, packet, &arguments_);
  }
  void CastRay(RTCScene scene, RTCRayHit* ray) {
    rtcIntersect1(scene, ray, &arguments_);
  }
  void CastStream(RTCScene scene, RTCRayHit* rays, unsigned int count) {
    for (unsigned int i = 0; i < count; ++i) CastRay(scene, rays + i);
  }

 private:
  RTCIntersectArguments arguments_;
#else
  using Context = RTCIntersectContext;
  /// @pre `context`, which filter functions are handed, outlives the queries.
  explicit CoherentQuery(Context* context) : context_(context) {
    rtcInitIntersectContext(context);
    context->flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  }
  /// kIntersect: rtcIntersect4, 8 or 16, matching the packet.
  template <auto kIntersect, typename Packet>
  void CastPacket(const int* valid, RTCScene scene, Packet* packet) {
    kIntersect(valid, scene, context_, packet);
  }
  void CastRay(RTCScene scene, RTCRayHit* ray) {
    rtcIntersect1(scene, context_, ray);
  }
  void CastStream(RTCScene scene, RTCRayHit* rays, unsigned int count) {
    rtcIntersect1M(scene, context_, rays, count, sizeof(RTCRayHit));
  }

 private:
  Context* context_;
#endif
};

}  // namespace atlas::sim
