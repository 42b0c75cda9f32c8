// Where the renderer draws: colour and depth buffers that can be read back, and a shadow map.
#pragma once

#include <vector>

#include "sim/render/colored_mesh.h"
#include "sim/render/gl_api.h"

namespace atlas::sim {

/// Members need the context that made it to be current.
class RenderTarget {
 public:
  RenderTarget(const gl::Api& api, int width, int height, int samples);
  ~RenderTarget();
  RenderTarget(const RenderTarget&) = delete;
  RenderTarget& operator=(const RenderTarget&) = delete;

  bool Fits(int width, int height, int samples) const {
    return width_ == width && height_ == height && samples_ == samples;
  }
  void Bind() const;
  RgbImage ReadRgb() const;
  /// Window depths in [0, 1], top row first.
  std::vector<float> ReadDepth() const;

 private:
  const gl::Api& api_;
  int width_, height_, samples_;
  gl::Uint framebuffer_ = 0, color_ = 0, depth_ = 0;
  gl::Uint resolved_framebuffer_ = 0, resolved_color_ = 0;  ///< 0 where nothing is multisampled
};

/// A square depth texture seen from the sun.
class ShadowMap {
 public:
  ShadowMap(const gl::Api& api, int size);
  ~ShadowMap();
  ShadowMap(const ShadowMap&) = delete;
  ShadowMap& operator=(const ShadowMap&) = delete;

  void Bind() const;
  gl::Uint texture() const { return texture_; }

 private:
  const gl::Api& api_;
  int size_;
  gl::Uint framebuffer_ = 0, texture_ = 0;
};

}  // namespace atlas::sim
