#include <GL/osmesa.h>
#include <dlfcn.h>

#include <stdexcept>

#include "sim/render/backends.h"
#include "sim/render/gl_api.h"

namespace atlas::sim {
namespace {

/// The context's own surface is never drawn to (the renderer draws into framebuffer objects).
constexpr int kSurfacePixels = 16;

struct OsMesa {
  decltype(&OSMesaCreateContextAttribs) CreateContext = nullptr;
  decltype(&OSMesaDestroyContext) DestroyContext = nullptr;
  decltype(&OSMesaMakeCurrent) MakeCurrent = nullptr;
  decltype(&OSMesaGetProcAddress) GetProcAddress = nullptr;

  bool Load() {
    void* library = nullptr;
    for (const char* name : {"libOSMesa.so.8", "libOSMesa.so"}) {
      if (library == nullptr) library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    }
    if (library == nullptr) return false;
    const auto find = [library](const char* name, auto* function) {
      *function = reinterpret_cast<std::remove_pointer_t<decltype(function)>>(dlsym(library, name));
      return *function != nullptr;
    };
    return find("OSMesaCreateContextAttribs", &CreateContext) &&
           find("OSMesaDestroyContext", &DestroyContext) && find("OSMesaMakeCurrent", &MakeCurrent) &&
           find("OSMesaGetProcAddress", &GetProcAddress);
  }
};

class OsMesaRenderContext final : public RenderContext {
 public:
  OsMesaRenderContext(const OsMesa& mesa, OSMesaContext context)
      : mesa_(mesa), context_(context), surface_(4 * kSurfacePixels * kSurfacePixels) {}
  ~OsMesaRenderContext() override { mesa_.DestroyContext(context_); }

  std::string backend() const override { return "osmesa"; }
  const char* LoadFunctions() {
    return gl::LoadApi(
        [this](const char* name) { return reinterpret_cast<void*>(mesa_.GetProcAddress(name)); }, api_.get());
  }
  bool Works() {
    if (!TryMakeCurrent()) return false;
    const bool works = api_->GetString(gl::kRenderer) != nullptr;
    Release();
    return works;
  }

 private:
  bool TryMakeCurrent() {
    return mesa_.MakeCurrent(context_, surface_.data(), GL_UNSIGNED_BYTE, kSurfacePixels, kSurfacePixels) !=
           0;
  }
  void MakeCurrent() override {
    if (!TryMakeCurrent()) throw std::runtime_error("renderer: the OSMesa context cannot be made current");
  }
  void Release() override { mesa_.MakeCurrent(nullptr, nullptr, 0, 0, 0); }

  OsMesa mesa_;
  OSMesaContext context_;
  std::vector<unsigned char> surface_;
};

}  // namespace

RenderContext::Made MakeOsMesaContext() {
  OsMesa mesa;
  if (!mesa.Load()) return {nullptr, "OSMesa: libOSMesa.so.8 is missing or too old"};
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0};
  const OSMesaContext context = mesa.CreateContext(attributes, nullptr);
  if (context == nullptr) return {nullptr, "OSMesa: no OpenGL 3.3 context"};
  auto made = std::make_shared<OsMesaRenderContext>(mesa, context);
  if (const char* missing = made->LoadFunctions()) {
    return {nullptr, std::string("OSMesa: OpenGL lacks ") + missing};
  }
  if (!made->Works()) return {nullptr, "OSMesa: another OpenGL library is loaded in this process"};
  return {made, ""};
}

}  // namespace atlas::sim
