// Letters of 5 x 7 pixels for pictures without a font at hand.
#pragma once

#include <string_view>

#include "sim/render/colored_mesh.h"

namespace atlas::experiments {

inline constexpr int kLetterWidth = 6, kLetterHeight = 8;  ///< pixels at scale 1, the gap included

/// Writes `text` with its upper left corner at (x, y), each pixel `scale` wide; what lies outside is cut off.
/// Small letters, digits and ( ) , - . / : % _ are there; capitals become small, all else a gap.
void DrawText(std::string_view text, int x, int y, int scale, const sim::Rgb& rgb, sim::RgbImage* image);

}  // namespace atlas::experiments
