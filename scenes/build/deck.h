// The raised steel deck that both helicopter scenes stand on.
#pragma once

#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

/// A 16 x 14 m deck with its top at z = 0 over ground at z = -3 m: rails along the +y and -x edges and half
/// of the -y edge, open edges elsewhere, and two 2.5 x 1 m stairwells in opposite corners. `floor` paints the
/// plates.
void AddDeck(SceneBuilder& scene, const Paint& floor);

}  // namespace atlas::scenes
