// The one label vocabulary: scenes paint meshes with it, cameras segment into it, semantics fuse it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace atlas::core {

#define ATLAS_LABELS(X)                      \
  X(Unknown, "unknown", 128, 128, 128)       \
  X(Ground, "ground", 122, 117, 108)         \
  X(Grass, "grass", 92, 138, 70)             \
  X(Path, "path", 178, 170, 152)             \
  X(Floor, "floor", 168, 160, 150)           \
  X(Deck, "deck", 104, 112, 120)             \
  X(Grating, "grating", 88, 96, 104)         \
  X(Rail, "rail", 226, 182, 40)              \
  X(Stanchion, "stanchion", 214, 150, 32)    \
  X(Stairs, "stairs", 150, 140, 132)         \
  X(Wall, "wall", 204, 192, 166)             \
  X(Roof, "roof", 158, 74, 58)               \
  X(Window, "window", 108, 148, 176)         \
  X(Door, "door", 122, 84, 54)               \
  X(Column, "column", 214, 206, 188)         \
  X(Ledge, "ledge", 190, 176, 150)           \
  X(Pipe, "pipe", 96, 100, 104)              \
  X(Chimney, "chimney", 140, 84, 70)         \
  X(Porch, "porch", 184, 150, 112)           \
  X(Furniture, "furniture", 142, 102, 64)    \
  X(Vehicle, "vehicle", 176, 40, 44)         \
  X(Wheel, "wheel", 40, 40, 44)              \
  X(Helicopter, "helicopter", 214, 216, 210) \
  X(Rotor, "rotor", 60, 64, 70)              \
  X(Skirt, "skirt", 70, 78, 92)              \
  X(Tree, "tree", 62, 104, 52)               \
  X(Rock, "rock", 110, 104, 98)              \
  X(Object, "object", 190, 150, 110)         \
  X(Robot, "robot", 64, 76, 152)

enum class Label : uint8_t {
#define X(name, text, r, g, b) k##name,
  ATLAS_LABELS(X)
#undef X
      kCount
};

constexpr size_t kLabelCount = static_cast<size_t>(Label::kCount);

struct LabelInfo {
  std::string_view name;
  std::array<uint8_t, 3> rgb;
};

/// Name and display colour of a label.
const LabelInfo& InfoOf(Label label);
/// The label called `name`, if any.
std::optional<Label> LabelFromName(std::string_view name);

}  // namespace atlas::core
