#include "core/files.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "scenes/mesh_import.h"
#include "tests/fuzz/fuzzed_reader.h"

namespace atlas::fuzz {
namespace {

const char* const kScene = R"(name: two
doc: a box and a sphere
ground: {size: [12, 12], label: grass}
spawn: {x: -3, y: 0, yaw_deg: 10}
object_box: {min: [-2, -2, 0.05], max: [2, 2, 2]}
parts:
  - {primitive: box, size: [1, 1, 1], pose: {xyz: [0, 0, 0.5], rpy_deg: [0, 0, 30]}, label: wall}
  - {primitive: sphere, radius: 0.4, pose: {xyz: [1, 1, 0.4]}, object: false}
)";
const char* const kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
    "face 4\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 "
    "3\n3 2 0 3\n";

/// The same tetrahedron in little endian.
std::string BinaryPly() {
  std::string bytes = kPly;
  bytes = bytes.substr(0, bytes.find("end_header\n") + 11);
  bytes.replace(bytes.find("ascii"), 5, "binary_little_endian");
  for (const float v : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) Put(&bytes, v);
  for (const auto& face : {std::array{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
    bytes.push_back(3);
    for (const int i : face) Put(&bytes, i);
  }
  return bytes;
}

const char* const kObj =
    "# a tetrahedron and a quad\nmtllib none.mtl\no first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvt "
    "0.5 "
    "0.5\nusemtl stone\ns 1\nf 1 3 2\nf 1//1 2//1 4//1\nf 2/1/1 3/1/1 4/1/1\nf 3/1 1/1 4/1\ng second\nv 2 0 "
    "0\nv 3 0 "
    "0\nv 3 1 0\nv 2 1 0\nf -4 -3 -2 -1\nl 1 2\n";
const char* const kStl =
    "solid one\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n  "
    "endloop\n "
    "endfacet\n facet normal 0 1 0\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 0 1\n  "
    "endloop\n "
    "endfacet\nendsolid one\n";

std::string BinaryStl() {
  std::string bytes(80, ' ');
  Put(&bytes, uint32_t{3});
  for (uint32_t face = 0; face < 3; ++face) {
    for (const float v :
         {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.5f * static_cast<float>(face)})
      Put(&bytes, v);
    Put(&bytes, uint16_t{0});
  }
  return bytes;
}

void ReadMesh(std::string_view, const std::filesystem::path& file) {
  scenes::ImportMesh(file, 1.0);
}

}  // namespace

std::vector<FuzzedReader> SceneReaders() {
  return {{"scene.yaml", {kScene}, [](auto, auto& file) { scenes::LoadSceneFile(file); }, true},
          {"mesh.ply", {kPly, BinaryPly()}, ReadMesh, true},
          {"mesh.obj", {kObj}, ReadMesh, true},
          {"mesh.stl", {kStl, BinaryStl()}, ReadMesh, true},
          {"robot.xml",
           {core::ReadFile(core::InstalledFile("robots/quadruped.xml"))},
           [](auto, auto& file) { robots::LoadRobot(file.string()); },
           true}};
}

}  // namespace atlas::fuzz
