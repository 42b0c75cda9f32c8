#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <stdexcept>

#include "sim/render/backends.h"
#include "sim/render/gl_api.h"

namespace atlas::sim {
namespace {

/// Entry points of libEGL, which stays loaded once it is.
struct Egl {
  decltype(&eglGetProcAddress) GetProcAddress = nullptr;
  decltype(&eglInitialize) Initialize = nullptr;
  decltype(&eglChooseConfig) ChooseConfig = nullptr;
  decltype(&eglBindAPI) BindApi = nullptr;
  decltype(&eglCreateContext) CreateContext = nullptr;
  decltype(&eglDestroyContext) DestroyContext = nullptr;
  decltype(&eglMakeCurrent) MakeCurrent = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplay = nullptr;

  bool Load() {
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return false;
    const auto find = [library](const char* name, auto* function) {
      *function = reinterpret_cast<std::remove_pointer_t<decltype(function)>>(dlsym(library, name));
      return *function != nullptr;
    };
    if (!find("eglGetProcAddress", &GetProcAddress) || !find("eglInitialize", &Initialize) ||
        !find("eglChooseConfig", &ChooseConfig) || !find("eglBindAPI", &BindApi) ||
        !find("eglCreateContext", &CreateContext) || !find("eglDestroyContext", &DestroyContext) ||
        !find("eglMakeCurrent", &MakeCurrent)) {
      return false;
    }
    GetPlatformDisplay =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(GetProcAddress("eglGetPlatformDisplayEXT"));
    return GetPlatformDisplay != nullptr;
  }
};

class EglContext final : public RenderContext {
 public:
  EglContext(const Egl& egl, EGLDisplay display, EGLContext context)
      : egl_(egl), display_(display), context_(context) {}
  /// The display is the whole process's and is left open: closing it would end the other contexts too.
  ~EglContext() override { egl_.DestroyContext(display_, context_); }

  std::string backend() const override { return "egl"; }
  const char* LoadFunctions() {
    MakeCurrent();
    const char* missing = gl::LoadApi(
        [this](const char* name) { return reinterpret_cast<void*>(egl_.GetProcAddress(name)); }, api_.get());
    Release();
    return missing;
  }

 private:
  void MakeCurrent() override {
    if (egl_.BindApi(EGL_OPENGL_API) == EGL_FALSE ||
        egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      throw std::runtime_error(
          "renderer: the EGL context cannot be made current (is another thread using it?)");
    }
  }
  void Release() override { egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

  Egl egl_;
  EGLDisplay display_;
  EGLContext context_;
};

}  // namespace

RenderContext::Made MakeEglContext() {
  Egl egl;
  if (!egl.Load()) return {nullptr, "EGL: libEGL.so.1 is missing or too old"};
  const EGLDisplay display =
      egl.GetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || egl.Initialize(display, nullptr, nullptr) == EGL_FALSE) {
    return {nullptr, "EGL: no surfaceless platform (Mesa's libegl-mesa0 and libgl1-mesa-dri provide it)"};
  }
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (egl.ChooseConfig(display, wanted, &config, 1, &configs) == EGL_FALSE || configs < 1) {
    return {nullptr, "EGL: no configuration with OpenGL"};
  }
  egl.BindApi(EGL_OPENGL_API);
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               3,
                               EGL_CONTEXT_MINOR_VERSION,
                               3,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_NONE};
  const EGLContext context = egl.CreateContext(display, config, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT) return {nullptr, "EGL: no OpenGL 3.3 context"};
  auto made = std::make_shared<EglContext>(egl, display, context);
  if (const char* missing = made->LoadFunctions()) {
    return {nullptr, std::string("EGL: OpenGL lacks ") + missing};
  }
  return {made, ""};
}

}  // namespace atlas::sim
