// SPDX-License-Identifier: GPL-3.0-or-later
// The shaders, GLSL 3.30.
#pragma once

namespace spheretree::view {

/// Light from the upper left behind the eye, a weaker one from the right, and the sky. Colours are squared, and the
/// result square-rooted, for linear light.
#define ST_GLSL_LIGHT                                                                                  \
  "#version 330 core\n"                                                                                \
  "uniform vec3 eye, key, fill;\n"                                                                     \
  "uniform vec4 cut;\n"  /* centre in the frame, radius [pixels]; distance from the eye */             \
  "uniform vec4 tint;\n" /* opacity factor in w; rgb replaces the colour by its share in tint_share */ \
  "uniform float tint_share;\n"                                                                        \
  "out vec4 pixel;\n"                                                                                  \
  "vec4 lit(vec4 colour, vec3 n, vec3 at) {\n"                                                         \
  "  vec3 to_eye = normalize(eye - at);\n"                                                             \
  "  if (dot(n, to_eye) < 0.0) n = -n;\n"                                                              \
  "  vec3 c = mix(colour.rgb, tint.rgb, tint_share);\n"                                                \
  "  float k = max(dot(n, key), 0.0), f = max(dot(n, fill), 0.0), sky = 0.5 + 0.5 * n.z;\n"            \
  "  float shine = pow(max(dot(n, normalize(key + to_eye)), 0.0), 48.0);\n"                            \
  "  vec3 light = c * c * (0.17 + 0.17 * sky + 0.62 * k + 0.14 * f) + vec3(0.10 * shine);\n"           \
  "  return vec4(sqrt(light), colour.a * tint.a);\n"                                                   \
  "}\n"                                                                                                \
  "bool isCut(vec3 at) {\n"                                                                            \
  "  float away = distance(gl_FragCoord.xy, cut.xy);\n"                                                \
  "  if (away > cut.z || distance(at, eye) > cut.w) return false;\n"                                   \
  "  int grain = (int(gl_FragCoord.x) + 2 * int(gl_FragCoord.y)) & 3;\n"                               \
  "  return away < cut.z * (0.8 + 0.05 * float(grain));\n"                                             \
  "}\n"

inline constexpr const char* kSurfaceVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
uniform mat4 model, view_projection;
out vec3 at, n, own;  // own: in the frame of the body
out vec4 c;
void main() {
  vec4 world = model * vec4(position, 1.0);
  at = world.xyz;
  n = mat3(model) * normal;
  own = position;
  c = colour;
  gl_Position = view_projection * world;
}
)";

inline constexpr const char* kSurfaceFragment = ST_GLSL_LIGHT R"(
in vec3 at, n;
in vec4 c;
void main() {
  if (isCut(at)) discard;
  pixel = lit(c, normalize(n), at);
}
)";

// A surface of which a burr has removed a part: CutDrawer. With kSurfaceVertex.
inline constexpr const char* kCutSurfaceFragment = ST_GLSL_LIGHT R"(
in vec3 at, n, own;
in vec4 c;
uniform isampler3D places;  // the brick of each block; -1: none, -2: all of the block was removed
uniform sampler3D bricks;   // of 10 x 10 x 10 distances from what was removed, 25 in a row, 25 rows in a layer
uniform float side;         // of a block
uniform vec3 low;           // corner of the first block
bool isRemoved() {
  vec3 along = (own - low) / side;
  ivec3 place = ivec3(floor(along));
  if (any(lessThan(place, ivec3(0))) || any(greaterThanEqual(place, textureSize(places, 0)))) return false;
  int brick = texelFetch(places, place, 0).r;
  if (brick < 0) return brick == -2;
  vec3 texel = 10.0 * vec3(brick % 25, brick / 25 % 25, brick / 625) + 0.5 + 8.0 * (along - vec3(place));
  return textureLod(bricks, texel / vec3(textureSize(bricks, 0)), 0.0).r < 0.0;
}
void main() {
  if (isCut(at) || isRemoved()) discard;
  pixel = lit(c, normalize(n), at);
}
)";

inline constexpr const char* kWallVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
layout(location = 3) in float below;
uniform mat4 model, view_projection;
out vec3 at, n;
out vec4 c;
out float depth;
void main() {
  vec4 world = model * vec4(position, 1.0);
  at = world.xyz;
  n = mat3(model) * normal;
  c = colour;
  depth = below;
  gl_Position = view_projection * world;
}
)";

inline constexpr const char* kWallFragment = ST_GLSL_LIGHT R"(
in vec3 at, n;
in vec4 c;
in float depth;
void main() {
  if (isCut(at) || depth < 0.0) discard;
  pixel = lit(c, normalize(n), at);
}
)";

// A square that faces the eye and contains the ball's outline.
inline constexpr const char* kBallVertex = R"(#version 330 core
layout(location = 0) in vec4 ball;
layout(location = 1) in vec4 colour;
uniform mat4 model, view_projection;
uniform vec3 eye;
out vec3 at;
flat out vec4 centre_radius, c;
void main() {
  vec3 centre = (model * vec4(ball.xyz, 1.0)).xyz;
  vec3 along = centre - eye;
  float away = length(along), r = ball.w;
  vec3 w = along / away;
  vec3 u = normalize(abs(w.z) < 0.9 ? cross(w, vec3(0, 0, 1)) : cross(w, vec3(1, 0, 0)));
  vec3 v = cross(w, u);
  float half_side = r * away / sqrt(max(away * away - r * r, 0.01 * r * r));
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  at = centre + half_side * (corner.x * u + corner.y * v);
  centre_radius = vec4(centre, r);
  c = colour;
  gl_Position = view_projection * vec4(at, 1.0);
}
)";

// The point of the ray nearest to the centre, then half a chord back. This avoids a difference of large squares, which
// would lose precision in float.
inline constexpr const char* kBallFragment = ST_GLSL_LIGHT R"(
in vec3 at;
flat in vec4 centre_radius, c;
uniform mat4 view_projection;
void main() {
  vec3 dir = normalize(at - eye), from = eye - centre_radius.xyz;
  vec3 nearest = from - dot(from, dir) * dir;
  float r = centre_radius.w, inside = r * r - dot(nearest, nearest);
  if (inside < 0.0) discard;
  vec3 n = nearest - sqrt(inside) * dir;
  vec3 hit = centre_radius.xyz + n;
  if (isCut(hit)) discard;
  vec4 clip = view_projection * vec4(hit, 1.0);
  gl_FragDepth = clamp(0.5 * clip.z / clip.w + 0.5, 0.0, 1.0);
  pixel = lit(c, n / r, hit);
}
)";

inline constexpr const char* kSkyVertex = R"(#version 330 core
out float height;
void main() {
  vec2 p = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0;
  height = 0.5 + 0.5 * p.y;
  gl_Position = vec4(p, 0.0, 1.0);
}
)";

inline constexpr const char* kSkyFragment = R"(#version 330 core
in float height;
uniform vec4 top, bottom;
out vec4 pixel;
void main() { pixel = mix(bottom, top, clamp(height, 0.0, 1.0)); }
)";

}  // namespace spheretree::view
