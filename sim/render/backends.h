// The two libraries that can make an off-screen context.
#pragma once

#include "sim/render/render_context.h"

namespace atlas::sim {

/// Mesa's surfaceless EGL platform with OpenGL 3.3.
RenderContext::Made MakeEglContext();
/// OSMesa, which draws into the program's own memory.
RenderContext::Made MakeOsMesaContext();

}  // namespace atlas::sim
