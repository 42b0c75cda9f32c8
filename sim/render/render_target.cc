#include "sim/render/render_target.h"

#include <stdexcept>

namespace atlas::sim {
namespace {

gl::Uint MakeBuffer(const gl::Api& api, gl::Enum attachment, gl::Enum format, int samples, int width,
                    int height) {
  gl::Uint buffer = 0;
  api.GenRenderbuffers(1, &buffer);
  api.BindRenderbuffer(gl::kRenderbuffer, buffer);
  api.RenderbufferStorageMultisample(gl::kRenderbuffer, samples > 1 ? samples : 0, format, width, height);
  api.FramebufferRenderbuffer(gl::kFramebuffer, attachment, gl::kRenderbuffer, buffer);
  return buffer;
}

void CheckComplete(const gl::Api& api) {
  if (api.CheckFramebufferStatus(gl::kFramebuffer) != gl::kFramebufferComplete) {
    throw std::runtime_error("renderer: this size or number of samples is not supported");
  }
}

}  // namespace

RenderTarget::RenderTarget(const gl::Api& api, int width, int height, int samples)
    : api_(api), width_(width), height_(height), samples_(samples) {
  api_.GenFramebuffers(1, &framebuffer_);
  api_.BindFramebuffer(gl::kFramebuffer, framebuffer_);
  color_ = MakeBuffer(api_, gl::kColorAttachment0, gl::kRgba8, samples, width, height);
  depth_ = MakeBuffer(api_, gl::kDepthAttachment, gl::kDepthComponent32f, samples, width, height);
  CheckComplete(api_);
  if (samples <= 1) return;
  api_.GenFramebuffers(1, &resolved_framebuffer_);
  api_.BindFramebuffer(gl::kFramebuffer, resolved_framebuffer_);
  resolved_color_ = MakeBuffer(api_, gl::kColorAttachment0, gl::kRgba8, 0, width, height);
  CheckComplete(api_);
}

RenderTarget::~RenderTarget() {
  api_.DeleteFramebuffers(1, &framebuffer_);
  api_.DeleteRenderbuffers(1, &color_);
  api_.DeleteRenderbuffers(1, &depth_);
  if (resolved_framebuffer_ == 0) return;
  api_.DeleteFramebuffers(1, &resolved_framebuffer_);
  api_.DeleteRenderbuffers(1, &resolved_color_);
}

void RenderTarget::Bind() const {
  api_.BindFramebuffer(gl::kFramebuffer, framebuffer_);
  api_.Viewport(0, 0, width_, height_);
}

RgbImage RenderTarget::ReadRgb() const {
  api_.BindFramebuffer(gl::kReadFramebuffer, framebuffer_);
  if (resolved_framebuffer_ != 0) {
    api_.BindFramebuffer(gl::kDrawFramebuffer, resolved_framebuffer_);
    api_.BlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, gl::kColorBufferBit, gl::kNearest);
    api_.BindFramebuffer(gl::kReadFramebuffer, resolved_framebuffer_);
  }
  const auto width = static_cast<size_t>(width_), height = static_cast<size_t>(height_);
  std::vector<uint8_t> rgba(4 * width * height);
  api_.ReadPixels(0, 0, width_, height_, gl::kRgba, gl::kUnsignedByte, rgba.data());
  RgbImage image{width_, height_, std::vector<uint8_t>(3 * width * height)};
  uint8_t* out = image.rgb.data();
  for (size_t row = height; row-- > 0;) {  // OpenGL's first row is the bottom one
    const uint8_t* in = rgba.data() + 4 * width * row;
    for (size_t column = 0; column < width; ++column, in += 4) {
      for (int channel = 0; channel < 3; ++channel) *out++ = in[channel];
    }
  }
  return image;
}

std::vector<float> RenderTarget::ReadDepth() const {
  const auto width = static_cast<size_t>(width_), height = static_cast<size_t>(height_);
  std::vector<float> depth(width * height);
  api_.BindFramebuffer(gl::kReadFramebuffer, framebuffer_);
  api_.ReadPixels(0, 0, width_, height_, gl::kDepthComponent, gl::kFloat, depth.data());
  for (size_t row = 0; row < height / 2; ++row) {
    std::swap_ranges(depth.data() + width * row, depth.data() + width * (row + 1),
                     depth.data() + width * (height - 1 - row));
  }
  return depth;
}

ShadowMap::ShadowMap(const gl::Api& api, int size) : api_(api), size_(size) {
  api_.GenTextures(1, &texture_);
  api_.BindTexture(gl::kTexture2D, texture_);
  api_.TexImage2D(gl::kTexture2D, 0, gl::kDepthComponent32f, size, size, 0, gl::kDepthComponent, gl::kFloat,
                  nullptr);
  const auto set = [&](gl::Enum name, gl::Enum value) {
    api_.TexParameteri(gl::kTexture2D, name, static_cast<int>(value));
  };
  set(gl::kTextureMinFilter, gl::kLinear);
  set(gl::kTextureMagFilter, gl::kLinear);
  set(gl::kTextureWrapS, gl::kClampToEdge);
  set(gl::kTextureWrapT, gl::kClampToEdge);
  set(gl::kTextureCompareMode, gl::kCompareRefToTexture);
  set(gl::kTextureCompareFunc, gl::kLessOrEqual);
  api_.GenFramebuffers(1, &framebuffer_);
  api_.BindFramebuffer(gl::kFramebuffer, framebuffer_);
  api_.FramebufferTexture2D(gl::kFramebuffer, gl::kDepthAttachment, gl::kTexture2D, texture_, 0);
  api_.DrawBuffer(0);
  api_.ReadBuffer(0);
  CheckComplete(api_);
}

ShadowMap::~ShadowMap() {
  api_.DeleteFramebuffers(1, &framebuffer_);
  api_.DeleteTextures(1, &texture_);
}

void ShadowMap::Bind() const {
  api_.BindFramebuffer(gl::kFramebuffer, framebuffer_);
  api_.Viewport(0, 0, size_, size_);
}

}  // namespace atlas::sim
