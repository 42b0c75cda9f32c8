// The builders that catalog.inc names.
#pragma once

#include "scenes/scene_spec.h"

namespace atlas::scenes {

#define ATLAS_SCENE(name, builder, doc) SceneSpec builder();
#include "scenes/catalog.inc"
#undef ATLAS_SCENE

}  // namespace atlas::scenes
