// An off-screen OpenGL context: no display, no window system and no GPU needed.
#pragma once

#include <memory>
#include <string>

namespace atlas::sim {

namespace gl {
struct Api;
}

/// Which library makes the context. Both are loaded at run time; kAuto tries EGL, then OSMesa. OSMesa works
/// only in a process that has loaded no other OpenGL library.
enum class RenderBackend { kAuto, kEgl, kOsMesa };

class RenderContext {
 public:
  struct Made {
    std::shared_ptr<RenderContext> context;  ///< null where none is to be had
    std::string why_not;                     ///< one line; empty where there is one
  };
  static Made Make(RenderBackend backend = RenderBackend::kAuto);

  virtual ~RenderContext() = default;
  RenderContext(const RenderContext&) = delete;
  RenderContext& operator=(const RenderContext&) = delete;

  virtual std::string backend() const = 0;  ///< "egl" or "osmesa"
  /// Functions to call while the context is current.
  const gl::Api& api() const { return *api_; }

  /// Makes the context current in this thread while it lives; others may use it afterwards.
  class Scope {
   public:
    explicit Scope(RenderContext& context) : context_(context) { context_.MakeCurrent(); }
    ~Scope() { context_.Release(); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    RenderContext& context_;
  };

 protected:
  RenderContext();
  virtual void MakeCurrent() = 0;
  virtual void Release() = 0;

  std::unique_ptr<gl::Api, void (*)(gl::Api*)> api_;
};

}  // namespace atlas::sim
