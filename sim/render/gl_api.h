// The part of OpenGL 3.3 that the renderer uses, as function pointers of one context's library.
//
// Nothing links to OpenGL: EGL or OSMesa is loaded at run time and hands these out (render_context.h).
#pragma once

#include <cstddef>
#include <functional>

namespace atlas::sim::gl {

using Enum = unsigned int;
using Uint = unsigned int;

/// Values of the OpenGL registry.
enum : Enum {
  kTriangles = 0x0004,
  kDepthTest = 0x0B71,
  kLess = 0x0201,
  kLessOrEqual = 0x0203,
  kFloat = 0x1406,
  kByte = 0x1400,
  kUnsignedByte = 0x1401,
  kDepthComponent = 0x1902,
  kRgba = 0x1908,
  kRenderer = 0x1F01,
  kNearest = 0x2600,
  kLinear = 0x2601,
  kTextureMagFilter = 0x2800,
  kTextureMinFilter = 0x2801,
  kTextureWrapS = 0x2802,
  kTextureWrapT = 0x2803,
  kTexture2D = 0x0DE1,
  kClampToEdge = 0x812F,
  kRgba8 = 0x8058,
  kTexture0 = 0x84C0,
  kTextureCompareMode = 0x884C,
  kTextureCompareFunc = 0x884D,
  kCompareRefToTexture = 0x884E,
  kArrayBuffer = 0x8892,
  kStaticDraw = 0x88E4,
  kFragmentShader = 0x8B30,
  kVertexShader = 0x8B31,
  kCompileStatus = 0x8B81,
  kLinkStatus = 0x8B82,
  kDepthComponent32f = 0x8CAC,
  kReadFramebuffer = 0x8CA8,
  kDrawFramebuffer = 0x8CA9,
  kFramebufferComplete = 0x8CD5,
  kColorAttachment0 = 0x8CE0,
  kDepthAttachment = 0x8D00,
  kFramebuffer = 0x8D40,
  kRenderbuffer = 0x8D41,
  kPolygonOffsetFill = 0x8037,
  kColorBufferBit = 0x4000,
  kDepthBufferBit = 0x0100,
};

// name, result, arguments
#define ATLAS_GL_FUNCTIONS(X)                                                                             \
  X(ActiveTexture, void, (Enum unit))                                                                     \
  X(AttachShader, void, (Uint program, Uint shader))                                                      \
  X(BindBuffer, void, (Enum target, Uint buffer))                                                         \
  X(BindFramebuffer, void, (Enum target, Uint framebuffer))                                               \
  X(BindRenderbuffer, void, (Enum target, Uint renderbuffer))                                             \
  X(BindTexture, void, (Enum target, Uint texture))                                                       \
  X(BindVertexArray, void, (Uint array))                                                                  \
  X(BlitFramebuffer, void,                                                                                \
    (int sx0, int sy0, int sx1, int sy1, int dx0, int dy0, int dx1, int dy1, Uint mask, Enum filter))     \
  X(BufferData, void, (Enum target, ptrdiff_t bytes, const void* data, Enum usage))                       \
  X(CheckFramebufferStatus, Enum, (Enum target))                                                          \
  X(Clear, void, (Uint mask))                                                                             \
  X(ClearColor, void, (float r, float g, float b, float a))                                               \
  X(ColorMask, void, (unsigned char r, unsigned char g, unsigned char b, unsigned char a))                \
  X(CompileShader, void, (Uint shader))                                                                   \
  X(CreateProgram, Uint, ())                                                                              \
  X(CreateShader, Uint, (Enum kind))                                                                      \
  X(DeleteBuffers, void, (int n, const Uint* buffers))                                                    \
  X(DeleteFramebuffers, void, (int n, const Uint* framebuffers))                                          \
  X(DeleteProgram, void, (Uint program))                                                                  \
  X(DeleteRenderbuffers, void, (int n, const Uint* renderbuffers))                                        \
  X(DeleteShader, void, (Uint shader))                                                                    \
  X(DeleteTextures, void, (int n, const Uint* textures))                                                  \
  X(DeleteVertexArrays, void, (int n, const Uint* arrays))                                                \
  X(Disable, void, (Enum what))                                                                           \
  X(DepthFunc, void, (Enum function))                                                                     \
  X(DrawBuffer, void, (Enum buffer))                                                                      \
  X(Enable, void, (Enum what))                                                                            \
  X(EnableVertexAttribArray, void, (Uint index))                                                          \
  X(FramebufferRenderbuffer, void, (Enum target, Enum attachment, Enum kind, Uint renderbuffer))          \
  X(FramebufferTexture2D, void, (Enum target, Enum attachment, Enum kind, Uint texture, int level))       \
  X(GenBuffers, void, (int n, Uint* buffers))                                                             \
  X(GenFramebuffers, void, (int n, Uint* framebuffers))                                                   \
  X(GenRenderbuffers, void, (int n, Uint* renderbuffers))                                                 \
  X(GenTextures, void, (int n, Uint* textures))                                                           \
  X(GenVertexArrays, void, (int n, Uint* arrays))                                                         \
  X(GetError, Enum, ())                                                                                   \
  X(GetProgramInfoLog, void, (Uint program, int size, int* length, char* log))                            \
  X(GetProgramiv, void, (Uint program, Enum what, int* value))                                            \
  X(GetShaderInfoLog, void, (Uint shader, int size, int* length, char* log))                              \
  X(GetShaderiv, void, (Uint shader, Enum what, int* value))                                              \
  X(GetString, const unsigned char*, (Enum what))                                                         \
  X(GetUniformLocation, int, (Uint program, const char* name))                                            \
  X(LinkProgram, void, (Uint program))                                                                    \
  X(MultiDrawArrays, void, (Enum mode, const int* first, const int* count, int draws))                    \
  X(PolygonOffset, void, (float factor, float units))                                                     \
  X(ReadBuffer, void, (Enum buffer))                                                                      \
  X(ReadPixels, void, (int x, int y, int width, int height, Enum format, Enum type, void* data))          \
  X(RenderbufferStorageMultisample, void, (Enum target, int samples, Enum format, int width, int height)) \
  X(ShaderSource, void, (Uint shader, int n, const char* const* text, const int* length))                 \
  X(TexImage2D, void,                                                                                     \
    (Enum target, int level, int internal, int width, int height, int border, Enum format, Enum type,     \
     const void* data))                                                                                   \
  X(TexParameteri, void, (Enum target, Enum name, int value))                                             \
  X(Uniform1i, void, (int location, int value))                                                           \
  X(Uniform1f, void, (int location, float value))                                                         \
  X(Uniform3fv, void, (int location, int n, const float* value))                                          \
  X(UniformMatrix4fv, void, (int location, int n, unsigned char transpose, const float* value))           \
  X(UseProgram, void, (Uint program))                                                                     \
  X(VertexAttribPointer, void,                                                                            \
    (Uint index, int size, Enum type, unsigned char normalized, int stride, const void* offset))          \
  X(Viewport, void, (int x, int y, int width, int height))

struct Api {
#define X(name, result, arguments) result(*name) arguments = nullptr;
  ATLAS_GL_FUNCTIONS(X)
#undef X
};

/// Fills `api` from a library's look-up; returns the first missing function's name, or null.
const char* LoadApi(const std::function<void*(const char*)>& find, Api* api);

/// A linked program of two GLSL sources. @pre a context is current; the sources are ours, so failure is a
/// bug.
Uint MakeProgram(const Api& api, const char* vertex_source, const char* fragment_source);

}  // namespace atlas::sim::gl
