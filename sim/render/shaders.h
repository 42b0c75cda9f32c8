// GLSL sources of the renderer's two programs.
#pragma once

namespace atlas::sim::shaders {

constexpr const char* kDepthVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 T_clip_mesh;
void main() { gl_Position = T_clip_mesh * vec4(position, 1.0); }
)";

constexpr const char* kDepthFragment = R"(#version 330 core
void main() {}
)";

constexpr const char* kColorVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;
uniform mat4 T_clip_mesh;
uniform mat4 T_map_mesh;
uniform mat4 T_shadow_map;
flat out vec3 albedo;
flat out vec3 normal_map;
out vec3 p_map;
out vec3 p_shadow;
void main() {
  vec4 p = T_map_mesh * vec4(position, 1.0);
  gl_Position = T_clip_mesh * vec4(position, 1.0);
  normal_map = mat3(T_map_mesh) * normal;
  albedo = color;
  p_map = p.xyz;
  p_shadow = (T_shadow_map * p).xyz;
}
)";

/// Sun with shadow, light from the sky and a little from the ground, and haze towards the horizon.
constexpr const char* kColorFragment = R"(#version 330 core
flat in vec3 albedo;
flat in vec3 normal_map;
in vec3 p_map;
in vec3 p_shadow;
uniform vec3 to_sun;
uniform vec3 eye;
uniform vec3 sky;
uniform float haze_per_m;
uniform int has_shadow;
uniform sampler2DShadow shadow_map;
out vec4 rgba;
void main() {
  vec3 to_eye = eye - p_map;
  vec3 n = normalize(normal_map);
  if (dot(n, to_eye) < 0.0) n = -n;
  float sun = max(dot(n, to_sun), 0.0);
  if (has_shadow != 0 && sun > 0.0) {
    vec3 at = 0.5 * p_shadow + 0.5;
    bool inside = all(greaterThan(at, vec3(0.0))) && all(lessThan(at, vec3(1.0)));
    if (inside) sun *= texture(shadow_map, at);
  }
  vec3 ambient = mix(vec3(0.34, 0.32, 0.30), vec3(0.50, 0.54, 0.60), 0.5 + 0.5 * n.z);
  vec3 lit = albedo * (ambient + 0.62 * sun * vec3(1.0, 0.97, 0.90));
  float haze = 1.0 - exp(-haze_per_m * length(to_eye));
  rgba = vec4(mix(min(lit, vec3(1.0)), sky, haze), 1.0);
}
)";

}  // namespace atlas::sim::shaders
