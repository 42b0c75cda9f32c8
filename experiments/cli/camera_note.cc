#include "experiments/cli/camera_note.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "core/safe_text.h"
#include "sim/render/render_context.h"

namespace atlas::experiments {

void TellOfMissingCamera(const std::vector<core::ParamRow>& rows) {
  const bool wanted = std::any_of(rows.begin(), rows.end(), [](const core::ParamRow& row) {
    return row.path == "sensors.depth_camera" && row.value == "true";
  });
  if (!wanted) return;
  const std::string why_not = sim::RenderContext::Make().why_not;
  if (why_not.empty()) return;
  std::cerr << fmt::format("sensors.depth_camera: cannot start on this machine, runs go without it: {}\n",
                           core::Printable(why_not));
}

}  // namespace atlas::experiments
