#include "sim/render/render_context.h"

#include <dlfcn.h>

#include "sim/render/backends.h"
#include "sim/render/gl_api.h"

namespace atlas::sim {

RenderContext::RenderContext() : api_(new gl::Api, [](gl::Api* api) { delete api; }) {}

RenderContext::Made RenderContext::Make(RenderBackend backend) {
  Made made;
  if (backend != RenderBackend::kOsMesa) made = MakeEglContext();
  if (made.context || backend == RenderBackend::kEgl) return made;
  const std::string egl_failure = made.why_not;
  made = MakeOsMesaContext();
  if (!made.context && !egl_failure.empty()) made.why_not = egl_failure + "; " + made.why_not;
  return made;
}

}  // namespace atlas::sim
