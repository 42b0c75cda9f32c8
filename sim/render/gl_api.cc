#include "sim/render/gl_api.h"

#include <stdexcept>

namespace atlas::sim::gl {
namespace {

Uint Compile(const Api& api, Enum kind, const char* source) {
  const Uint shader = api.CreateShader(kind);
  api.ShaderSource(shader, 1, &source, nullptr);
  api.CompileShader(shader);
  int ok = 0;
  api.GetShaderiv(shader, kCompileStatus, &ok);
  if (ok != 0) return shader;
  char log[1024] = "";
  api.GetShaderInfoLog(shader, sizeof log, nullptr, log);
  throw std::runtime_error(std::string("renderer: shader does not compile: ") + log);
}

}  // namespace

const char* LoadApi(const std::function<void*(const char*)>& find, Api* api) {
#define X(name, result, arguments)                                     \
  api->name = reinterpret_cast<result(*) arguments>(find("gl" #name)); \
  if (api->name == nullptr) return "gl" #name;
  ATLAS_GL_FUNCTIONS(X)
#undef X
  return nullptr;
}

Uint MakeProgram(const Api& api, const char* vertex_source, const char* fragment_source) {
  const Uint vertex = Compile(api, kVertexShader, vertex_source);
  const Uint fragment = Compile(api, kFragmentShader, fragment_source);
  const Uint program = api.CreateProgram();
  api.AttachShader(program, vertex);
  api.AttachShader(program, fragment);
  api.LinkProgram(program);
  api.DeleteShader(vertex);
  api.DeleteShader(fragment);
  int ok = 0;
  api.GetProgramiv(program, kLinkStatus, &ok);
  if (ok != 0) return program;
  char log[1024] = "";
  api.GetProgramInfoLog(program, sizeof log, nullptr, log);
  throw std::runtime_error(std::string("renderer: program does not link: ") + log);
}

}  // namespace atlas::sim::gl
