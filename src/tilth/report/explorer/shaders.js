// SPDX-License-Identifier: BSD-3-Clause
// Programs of the graphics card. A value beyond 1e37 means "no value"; what is cut away by a section
// is drawn outside of the picture.
"use strict";
Tilth.shaders = {};

const CUT = `
uniform vec4 planes[3];
uniform vec2 range;
bool cut(vec3 place) {
  for (int k = 0; k < 3; k++) if (dot(planes[k].xyz, place) > planes[k].w) return true;
  return false;
}
float share(float value) { return value > 1e37 ? -1.0 : clamp((value - range.x) / (range.y - range.x), 0.0, 1.0); }
`;
const COLOUR = `
uniform sampler2D map;
vec3 colour(float share) { return share < -0.5 ? vec3(0.75) : texture2D(map, vec2(share * 0.99609375 + 0.001953125, 0.5)).rgb; }
`;

Tilth.shaders.domains = {
  vertexShader: `${CUT}
attribute vec3 corner; attribute vec3 centre; attribute vec3 a; attribute vec3 b; attribute vec3 c;
attribute float value;
uniform float plane; uniform float reach;
varying float part; varying vec3 seen; varying vec2 inside;
void main() {
  vec3 s = corner * reach;
  vec3 place = centre + s.x * a + s.y * b + (plane > 0.5 ? s.x * s.y : s.z) * c;
  part = share(value);
  inside = s.xy;
  vec4 view = modelViewMatrix * vec4(place, 1.0);
  seen = view.xyz;
  gl_Position = cut(centre) ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * view;
}`,
  fragmentShader: `${COLOUR}
uniform float plane; varying float part; varying vec3 seen; varying vec2 inside;
void main() {
  float light = 1.0;
  if (plane < 0.5) {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    light = 0.55 + 0.45 * abs(dot(normal, normalize(vec3(0.35, 0.55, 0.75))));
  }
  gl_FragColor = vec4(colour(part) * light, 1.0);
}`,
};

// Weighted sums of the values around each pixel, and whether domains cover it.
Tilth.shaders.sums = {
  vertexShader: Tilth.shaders.domains.vertexShader,
  fragmentShader: `
varying float part; varying vec2 inside;
void main() {
  if (part < -0.5) discard;
  float weight = exp(-0.55 * dot(inside, inside));
  float covered = max(abs(inside.x), abs(inside.y)) < 1.12 ? 1.0 : 0.0;
  gl_FragColor = vec4(part * weight, weight, covered, 1.0);
}`,
};

Tilth.shaders.mean = {
  vertexShader: `varying vec2 place; void main() { place = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`,
  fragmentShader: `${COLOUR}
uniform sampler2D sums; uniform vec2 gap; varying vec2 place;
bool covered(vec2 shift) { return texture2D(sums, place + shift * gap).z > 0.5; }
// Between domains that have parted by less than about a spacing: soil on two opposite sides.
bool between() {
  for (int k = 0; k < 4; k++) {
    float angle = 0.785398 * float(k);
    vec2 along = vec2(cos(angle), sin(angle));
    bool ahead = false, behind = false;
    for (int i = 1; i <= 4; i++) {
      ahead = ahead || covered(0.25 * float(i) * along);
      behind = behind || covered(-0.25 * float(i) * along);
    }
    if (ahead && behind) return true;
  }
  return false;
}
void main() {
  vec4 sum = texture2D(sums, place);
  if (sum.y < 1e-4 || (sum.z < 0.5 && !between())) discard;
  gl_FragColor = vec4(colour(sum.x / sum.y), 1.0);
}`,
};

Tilth.shaders.points = {
  vertexShader: `${CUT}
attribute float value; uniform float size; varying float part;
void main() {
  part = share(value);
  gl_PointSize = size;
  gl_Position = cut(position) ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`,
  fragmentShader: `${COLOUR}
uniform float plane; varying float part;
void main() {
  vec2 place = 2.0 * gl_PointCoord - 1.0;
  float square = dot(place, place);
  if (square > 1.0) discard;
  float light = plane > 0.5 ? 1.0 : 0.55 + 0.45 * sqrt(1.0 - square);
  gl_FragColor = vec4(colour(part) * light, 1.0);
}`,
};

// Segments of a width in pixels.
Tilth.shaders.lines = {
  vertexShader: `
attribute vec2 corner; attribute vec3 start; attribute vec3 end;
uniform vec2 pixels; uniform float width;
void main() {
  vec4 from = projectionMatrix * modelViewMatrix * vec4(start, 1.0);
  vec4 to = projectionMatrix * modelViewMatrix * vec4(end, 1.0);
  vec2 along = (to.xy - from.xy) * pixels;
  along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
  vec4 place = corner.x < 0.0 ? from : to;
  vec2 shift = vec2(-along.y, along.x) * corner.y + along * corner.x;
  place.xy += shift * width / pixels;
  gl_Position = place;
}`,
  fragmentShader: `uniform vec3 tint; void main() { gl_FragColor = vec4(tint, 1.0); }`,
};
