#include "core/labels.h"

namespace atlas::core {
namespace {

constexpr std::array<LabelInfo, kLabelCount> kLabels = {{
#define X(name, text, r, g, b) {text, {r, g, b}},
    ATLAS_LABELS(X)
#undef X
}};

}  // namespace

const LabelInfo& InfoOf(Label label) {
  return kLabels[static_cast<size_t>(label) % kLabelCount];
}

std::optional<Label> LabelFromName(std::string_view name) {
  for (size_t i = 0; i < kLabelCount; ++i) {
    if (kLabels[i].name == name) return static_cast<Label>(i);
  }
  return std::nullopt;
}

}  // namespace atlas::core
