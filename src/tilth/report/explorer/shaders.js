// SPDX-License-Identifier: BSD-3-Clause
// Programs of the graphics card. A value beyond 1e37 means "no value".
"use strict";
Tilth.shaders = {};
Tilth.none = 2e38;

const SHARE = `
uniform vec2 range;
float share(float value) { return value > 1e37 ? -1.0 : clamp((value - range.x) / (range.y - range.x), 0.0, 1.0); }
`;
const COLOUR = `
uniform sampler2D map;
vec3 colour(float share) { return share < -0.5 ? vec3(0.75) : texture2D(map, vec2(share * 0.99609375 + 0.001953125, 0.5)).rgb; }
`;

Tilth.shaders.domains = {
  vertexShader: `${SHARE}
attribute float value; varying float part; varying vec3 seen;
void main() {
  part = share(value);
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  seen = view.xyz;
  gl_Position = projectionMatrix * view;
}`,
  fragmentShader: `${COLOUR}
uniform float plane; varying float part; varying vec3 seen;
void main() {
  float light = 1.0;
  if (plane < 0.5) {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    light = 0.55 + 0.45 * abs(dot(normal, normalize(vec3(0.35, 0.55, 0.75))));
  }
  gl_FragColor = vec4(colour(part) * light, 1.0);
}`,
};

// The means of a continuous field between the four places around, where there is soil.
Tilth.shaders.field = {
  vertexShader: `varying vec2 place; void main() { place = uv; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`,
  fragmentShader: `${SHARE}${COLOUR}
uniform sampler2D means; uniform sampler2D mask; varying vec2 place;
void main() {
  float soil = texture2D(mask, place).r;
  float edge = clamp((soil - 0.5) / max(fwidth(soil), 1e-4) + 0.5, 0.0, 1.0);
  if (edge == 0.0) discard;
  ivec2 size = textureSize(means, 0);
  vec2 at = place * vec2(size) - 0.5;
  ivec2 first = ivec2(floor(at));
  vec2 part = at - floor(at);
  float sum = 0.0, weight = 0.0;
  for (int k = 0; k < 4; k++) {
    ivec2 side = ivec2(k & 1, k >> 1);
    float value = texelFetch(means, clamp(first + side, ivec2(0), size - 1), 0).r;
    float near = (side.x == 1 ? part.x : 1.0 - part.x) * (side.y == 1 ? part.y : 1.0 - part.y);
    if (value < 1e37) { sum += near * value; weight += near; }
  }
  gl_FragColor = vec4(colour(weight > 0.0 ? share(sum / weight) : -1.0), edge);
}`,
};

Tilth.shaders.points = {
  vertexShader: `${SHARE}
attribute float value; uniform float size; varying float part;
void main() {
  part = share(value);
  gl_PointSize = size;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
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
attribute vec2 corner; attribute vec3 end;
uniform vec2 pixels; uniform float width;
void main() {
  vec4 from = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
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
