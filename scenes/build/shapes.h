// Closed, outward-oriented solids from which scenes are assembled.
//
// Every function returns one watertight shell: each edge is shared by exactly two triangles,
// counter-clockwise seen from outside. Sizes in metres, angles in radians, coordinates in the map frame
// unless a pose is given.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/mesh.h"

namespace atlas::scenes {

using Ring = std::vector<core::Vec3>;  ///< a closed polygon, corners in order

/// Skin over a sequence of rings with equal corner counts, closed at both ends. The end rings are star-shaped
/// about their centroids. @pre at least two rings of at least three corners.
core::TriMesh MakeLoft(const std::vector<Ring>& rings);

core::TriMesh MakeBox(const core::Vec3& half_size, const core::Pose& T_map_box);

/// A frustum along local z from -half_length to half_length; equal radii give a cylinder, a zero top radius a
/// sharp cone (approximated by a 1 mm flat).
core::TriMesh MakeFrustum(double bottom_radius, double top_radius, double half_length,
                          const core::Pose& T_map_frustum, int corners = 16);
core::TriMesh MakeCylinder(double radius, double half_length, const core::Pose& T_map_cylinder,
                           int corners = 16);
core::TriMesh MakeSphere(double radius, const core::Pose& T_map_sphere, int corners = 24);
core::TriMesh MakeCapsule(double radius, double half_length, const core::Pose& T_map_capsule,
                          int corners = 16);

/// A simple polygon (counter-clockwise, may be concave) in the local xy plane, extruded from z0 to z1.
core::TriMesh MakeExtrusion(const std::vector<core::Vec2>& polygon, double z0, double z1,
                            const core::Pose& T_map_polygon);

/// Outlines with equal corner counts (counter-clockwise, may be concave), the k-th at local z = z[k], skinned
/// and capped: a body whose side view changes over its width. @pre z ascends.
core::TriMesh MakeProfileLoft(const std::vector<std::vector<core::Vec2>>& outlines,
                              const std::vector<double>& z, const core::Pose& T_map_outline);

/// A round bar of constant radius along a polyline, mitred at the bends. @pre consecutive points differ and
/// no bend is sharper than 90 degrees.
core::TriMesh MakeTube(const std::vector<core::Vec3>& path, double radius, int corners = 12);

/// A plate over four coplanar corners (counter-clockwise seen from its outer side): from `depth` behind their
/// plane to `proud` before it.
core::TriMesh MakePanel(const Ring& corners, double proud, double depth);

/// A plate that follows a lofted surface over corners [j0, j1] of rings [i0, i1], from `depth` below the
/// surface to `proud` above it: windows and doors on a curved body. Corner indices wrap around.
core::TriMesh MakeLoftPatch(const std::vector<Ring>& rings, int i0, int i1, int j0, int j1, double proud,
                            double depth);

/// The pose whose local z points from `a` to `b`, at their middle.
core::Pose PoseBetween(const core::Vec3& a, const core::Vec3& b);

/// Signed volume; positive where triangles face outward.
double VolumeM3(const core::TriMesh& mesh);

}  // namespace atlas::scenes
