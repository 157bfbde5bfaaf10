// The programs that run on the graphics unit. Colours are computed in linear light and written as sRGB.

const COMMON = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
`;

/** Shadow of the sun: the mean of 3 × 3 comparisons, so that its edge is soft. */
const SHADOW = `
uniform sampler2DShadow shadowMap;
uniform mat4 sunMatrix;
float sunlight(vec3 position, float bias) {
  vec4 p = sunMatrix * vec4(position, 1.0);
  vec3 at = p.xyz * 0.5 + 0.5;
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  float sum = 0.0, texel = 1.6 / float(textureSize(shadowMap, 0).x);
  for (int i = -1; i <= 1; i++)
    for (int j = -1; j <= 1; j++)
      sum += texture(shadowMap, vec3(at.xy + texel * vec2(i, j), at.z - bias));
  return sum / 9.0;
}
`;

const SOLID_VERTEX = `${COMMON}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 camera, pose;
uniform vec3 scale;
out vec3 worldPosition, worldNormal;
void main() {
  vec4 world = pose * vec4(position * scale, 1.0);
  worldPosition = world.xyz;
  // Normals are scaled the other way round than positions.
  vec3 safe = mix(scale, vec3(1e-9), lessThan(abs(scale), vec3(1e-9)));
  worldNormal = mat3(pose) * (normal / safe);
  gl_Position = camera * world;
}
`;

const SOLID_FRAGMENT = `${COMMON}${SHADOW}
in vec3 worldPosition, worldNormal;
uniform vec3 eye, toSun;
uniform vec4 color;
out vec4 result;
void main() {
  vec3 n = normalize(worldNormal), v = normalize(eye - worldPosition);
  if (dot(n, v) < 0.0) n = -n; // open meshes show their inner sides
  float lit = max(dot(n, toSun), 0.0) * sunlight(worldPosition, 0.004);
  vec3 sky = mix(vec3(0.27, 0.26, 0.25), vec3(0.54, 0.57, 0.62), 0.5 + 0.5 * n.z);
  float shine = pow(max(dot(n, normalize(toSun + v)), 0.0), 40.0) * 0.18 * lit;
  float rim = 0.06 * pow(1.0 - max(dot(n, v), 0.0), 3.0);
  vec3 light = pow(color.rgb, vec3(2.2)) * (sky + vec3(0.74, 0.71, 0.65) * lit) + shine + rim;
  result = vec4(pow(min(light, 1.0), vec3(1.0 / 2.2)), color.a);
}
`;

const DEPTH_FRAGMENT = `${COMMON}
void main() {}
`;

const GROUND_VERTEX = `${COMMON}
uniform mat4 camera;
uniform vec4 disc; // centre and radius
out vec3 worldPosition;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  worldPosition = vec3(disc.xy + corner * disc.w, disc.z);
  gl_Position = camera * vec4(worldPosition, 1.0);
}
`;

const GROUND_FRAGMENT = `${COMMON}${SHADOW}
in vec3 worldPosition;
uniform vec4 disc;
uniform float spacing;
uniform vec3 ground, lines;
out vec4 result;
float grid(float spacing) {
  vec2 p = worldPosition.xy / spacing, width = fwidth(p);
  vec2 distance = abs(fract(p - 0.5) - 0.5) / max(width, vec2(1e-6));
  // Where lines come closer than some pixels they fade.
  float dense = max(width.x, width.y);
  return (1.0 - min(min(distance.x, distance.y), 1.0)) * (1.0 - smoothstep(0.15, 0.5, dense));
}
void main() {
  float fade = 1.0 - smoothstep(0.35, 1.0, length(worldPosition.xy - disc.xy) / disc.w);
  float line = max(grid(spacing) * 0.45, grid(spacing * 5.0) * 0.9);
  vec3 color = mix(ground, lines, line);
  color *= mix(0.68, 1.0, sunlight(worldPosition, 0.002));
  result = vec4(color, fade);
}
`;

/** A ribbon of constant width on the screen, one instance a segment. */
const RIBBON_VERTEX = `${COMMON}
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
uniform mat4 camera;
uniform vec2 viewport;
uniform float width, now;
uniform vec4 color;
out vec4 shade;
void main() {
  vec4 a = camera * vec4(from, 1.0), b = camera * vec4(to, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * viewport;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  float side = float(gl_VertexID & 1) * 2.0 - 1.0;
  vec4 at = gl_VertexID < 2 ? a : b;
  at.xy += vec2(-along.y, along.x) * side * width / viewport * at.w;
  shade = vec4(color.rgb, float(gl_InstanceID) < now ? 1.0 : 0.25);
  gl_Position = at;
}
`;

const RIBBON_FRAGMENT = `${COMMON}
in vec4 shade;
out vec4 result;
void main() { result = shade; }
`;
