// The shaders of organisms. Positions are the 16-bit words of the frame; motion, color by value and size are computed here.

const COMMON = /* glsl */ `
uniform vec3 size;        // size of the world [m]
uniform vec3 wrap;        // 1 along axes that wrap around
uniform float alpha;      // progress from the last frame to this one
uniform float radius;     // radius of the body [m]
uniform float least;      // minimum radius on the screen [px]
uniform float lens;       // pixels per meter at a distance of one meter
uniform float day;        // light at the surface 0 … 1
uniform float murk;       // attenuation of light with depth [1/m], 0 on land
uniform vec3 plain;       // color of the kind
uniform float byValue;    // 1 if the value determines the color
uniform vec3 mute;        // color of organisms without a value
uniform vec3 shallow, deep, night; // colors of the water
uniform sampler2D ramp;
uniform sampler2D relief; // heights of the ground [m]
uniform vec2 cells;       // cells of the relief; 0 if the ground is flat
uniform vec2 sizes;       // radius at the lowest and highest value of a gene, relative to the species'; 1 if none

attribute vec4 now;       // x, y, z (in a plane, genes), heading | value << 8
attribute float genes;    // in a volume: size | stripes << 8
attribute vec4 before;    // x, y, z, heading | newborn << 8

varying vec3 vColour;

float ground(vec2 p) {
  if (cells.x < 1.0) return 0.0;
  vec2 at = p * cells - 0.5;
  vec2 low = floor(at), part = at - low;
  vec2 high = low + 1.0;
  ivec2 a = ivec2(mix(clamp(low, vec2(0.0), cells - 1.0), mod(low, cells), wrap.xy));
  ivec2 b = ivec2(mix(clamp(high, vec2(0.0), cells - 1.0), mod(high, cells), wrap.xy));
  float bottom = mix(texelFetch(relief, a, 0).r, texelFetch(relief, ivec2(b.x, a.y), 0).r, part.x);
  float top = mix(texelFetch(relief, ivec2(a.x, b.y), 0).r, texelFetch(relief, b, 0).r, part.x);
  return mix(bottom, top, part.y);
}

vec3 place() {
  vec3 a = before.xyz / 65535.0, d = now.xyz / 65535.0 - a;
  d -= wrap * floor(d + 0.5);
  vec3 p = a + d * alpha;
  p = mix(p, fract(p), wrap);
  vec3 at = p * size;
  if (size.z <= 0.0) at.z = ground(p.xy) + radius;
  return at;
}

float heading() {
  float a = mod(before.w, 256.0), d = mod(now.w, 256.0) - a;
  d -= 256.0 * floor(d / 256.0 + 0.5);
  return (a + d * alpha) * 0.02454369260617026;
}

float gene(float value, vec2 ends, float unknown) { return value < 0.5 ? unknown : mix(ends.x, ends.y, (value - 1.0) / 254.0); }

float shown() { return size.z > 0.0 ? genes : now.z; }
float entered() { return before.w > 255.5 ? 0.25 + 0.75 * alpha : 1.0; }
float grown() { return radius * gene(mod(shown(), 256.0), sizes, 1.0); } // [m]

// Water between the camera and an organism makes it paler.
vec3 through(vec3 own, vec3 at) {
  if (murk <= 0.0 || byValue > 0.5) return own;
  vec3 way = at - cameraPosition + 1e-6, enters = (step(way, vec3(0.0)) * size - cameraPosition) / way;
  float within = length(way) * (1.0 - max(0.0, max(enters.x, max(enters.y, enters.z))));
  vec3 haze = mix(night, mix(deep, shallow, exp(-murk * max(0.0, size.z - at.z))), day);
  return mix(haze, own, exp(-0.25 * murk * max(0.0, within)));
}

vec3 colour(vec3 at) {
  float value = floor(now.w / 256.0);
  vec3 told = value < 0.5 ? mute : texture2D(ramp, vec2((value - 0.5) / 255.0, 0.5)).rgb; // 0: no such value
  vec3 own = mix(plain, told, byValue);
  float light = day * exp(-murk * max(0.0, size.z - at.z));
  return own * mix(0.7, 1.0, light);
}
`;

export const POINT_VERTEX = /* glsl */ `
${COMMON}
varying vec2 vAhead;
varying float vPixels;
varying vec3 vUp;         // upward direction on the screen; cosine of the viewing angle
uniform float pointed;    // 1 if the heading is shown
uniform float lying;      // 1 for bodies that lie flat on the ground
uniform float grows;      // 1 for plants on land, which are tufts at close range
uniform float drifts;     // 1 for plankton, which at close range is a cell with a wall and spots
varying float vGrows;
varying float vDrifts;
varying float vTuft;      // 0: distant point … 1: tuft
varying float vWay;       // pseudorandom number from the position

void main() {
  vec3 at = place();
  vColour = through(colour(at), at);
  vec4 seen = modelViewMatrix * vec4(at, 1.0);
  gl_Position = projectionMatrix * seen;
  float pixels = max(grown() * lens / -seen.z, least) * entered() * (1.0 + 0.45 * pointed);
  vGrows = grows, vDrifts = drifts * (1.0 - byValue) * smoothstep(4.0, 9.0, pixels);
  vTuft = grows * smoothstep(3.5, 6.0, pixels);
  vWay = fract(sin(dot(now.xy, vec2(0.0129898, 0.078233))) * 43758.5453);
  pixels *= 1.0 + 0.7 * vTuft;
  vec4 front = projectionMatrix * (seen + vec4(0.0, 0.0, 2.0 * radius * vTuft, 0.0));
  gl_Position.z = front.z / front.w * gl_Position.w; // the ground in front does not cut off its foot
  gl_PointSize = 2.0 * pixels;
  vPixels = pixels;
  vec3 up = (modelViewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz;
  vUp = lying > 0.5 && length(up.xy) > 0.01 ? vec3(normalize(up.xy), max(0.15, abs(up.z))) : vec3(0.0);
  float h = heading();
  vec2 ahead = (modelViewMatrix * vec4(cos(h), sin(h), 0.0, 0.0)).xy;
  vAhead = pointed > 0.5 && length(ahead) > 0.1 ? normalize(ahead) : vec2(0.0);
}`;

/** Everything that covers the followed organism fades: a fine, irregular pattern of pixels is left out. */
export const HIDES = /* glsl */ `
uniform vec4 clear;       // pixel and depth of the followed organism, and radius of fading [px] (0: none)

bool hides() {
  if (clear.w <= 0.0 || gl_FragCoord.z >= clear.z) return false;
  float near = 1.0 - smoothstep(0.6, 1.0, distance(gl_FragCoord.xy, clear.xy) / clear.w);
  float grain = fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
  return grain < 0.8 * near;
}
`;

export const POINT_FRAGMENT = /* glsl */ `
${HIDES}
varying vec3 vColour;
varying vec2 vAhead;
varying float vPixels;
varying vec3 vUp;
varying float vTuft;
varying float vGrows;
varying float vDrifts;
varying float vWay;

// Coverage by blades of grass, which bend to both sides from a root at the bottom, and their brightness.
vec2 blades(vec2 q) {
  float h = 0.5 * (q.y + 1.0), cover = 0.0, tone = 1.0;
  for (int i = 0; i < 9; i++) { // the outer ones are behind
    float n = fract(13.0 * vWay + 0.618 * float(i)), side = (2.0 * mod(float(i), 2.0) - 1.0) * (8.0 - float(i)) / 8.0 + 0.2 * (n - 0.5);
    float up = h / (1.0 - 0.4 * side * side - 0.22 * n), wide = 0.075 * (1.0 - up * up) * min(1.0, 0.5 + 3.0 * h);
    float own = up < 1.0 ? 1.0 - smoothstep(wide, wide + 1.4 / vPixels, abs(q.x - side * (0.1 + 0.95 * h * h))) : 0.0;
    cover = max(cover, own), tone = mix(tone, 0.75 + 0.5 * n, own);
  }
  return vec2(cover, tone);
}

void main() {
  if (hides()) discard;
  vec2 q = vec2(2.0 * gl_PointCoord.x - 1.0, 1.0 - 2.0 * gl_PointCoord.y);
  if (vUp.z > 0.0) q = vec2(dot(q, vec2(vUp.y, -vUp.x)), dot(q, vUp.xy) / vUp.z);
  float edge;               // 0 at the center, 1 at the rim
  if (vAhead == vec2(0.0) || vPixels < 2.5) edge = length(q);
  else {                    // drop that points forward
    float x = dot(q, vAhead), y = abs(dot(q, vec2(-vAhead.y, vAhead.x)));
    float round = length(vec2(x + 0.38, y)) / 0.6, tip = x > -0.2 ? y / max(0.001, 0.52 * (0.98 - x)) : 9.0;
    edge = min(round, tip);
  }
  float blur = 1.2 / max(vPixels, 1.2), cover = 1.0 - smoothstep(1.0 - blur, 1.0, edge);
  vec2 tuft = vTuft > 0.0 ? blades(q) : vec2(0.0);
  if (vGrows > 0.5) cover = mix(0.5 * cover, tuft.x, vTuft); // at a distance, the ground is also green
  if (cover < mix(0.1, 0.45, vTuft)) discard; // pale edges of tufts would cut holes into those behind them
  if (vTuft > 0.5) {
    gl_FragColor = vec4(vColour * tuft.y * (0.6 + 0.25 * (q.y + 1.0)), cover);
    return;
  }
  float rim = smoothstep(1.0 - 2.6 / max(vPixels, 4.0), 1.0, edge);
  if (vDrifts > 0.0) {
    float turn = 6.28 * vWay, spots = 0.0;
    for (int i = 0; i < 5; i++) {
      float a = turn + 1.2566 * float(i);
      spots = max(spots, 1.0 - smoothstep(0.14, 0.26, distance(q, (0.38 + 0.12 * fract(vWay * (3.0 + float(i)))) * vec2(cos(a), sin(a)))));
    }
    float wall = smoothstep(0.78, 0.86, edge), core = max(wall, spots);
    gl_FragColor = vec4(mix(vColour, vColour * mix(1.25, 0.7, core), vDrifts), cover * mix(1.0, 0.45 + 0.55 * core, vDrifts));
    return;
  }
  vec3 lit = vColour * (1.06 - 0.16 * length(q - vec2(-0.25, 0.3)));
  gl_FragColor = vec4(mix(lit, vColour * 0.66, 0.6 * rim), cover);
}`;

/** The pose of a body on land: enlarged bodies stand on the ground. */
const POSE = /* glsl */ `
float scaled(inout vec3 at) {
  float scale = max(grown(), least * -(viewMatrix * vec4(at, 1.0)).z / lens) * entered();
  scale *= max(0.001, smoothstep(2.5, 4.0, distance(at, cameraPosition) / scale)); // the camera enters no body
  if (size.z <= 0.0) at.z += scale - radius;
  return scale;
}
`;

export const BODY_VERTEX = /* glsl */ `
${COMMON}
${POSE}
attribute vec3 corner;    // corner of the body in radii; forward is +x
attribute vec3 facing;
attribute float tone;     // brightness of the part: 0 black, 1 as it is, 2 white
uniform vec3 sun;
uniform float gait;       // 1: legs, 2: wings, 3: tail
uniform float rim;        // 0 for the body, or the margin of its rim in water, in radii
uniform vec3 edge;        // color of the rim
uniform float nearer;     // shift toward the viewer, as a share of the depth
uniform vec4 followed;    // position of the followed organism [m]; 1 if there is one
uniform vec2 striped;     // stripes at the lowest and highest value of a gene
varying float vOwn;       // 1 for the followed organism, which does not fade
varying vec2 vStripes;    // phase of the stripes, and their width 0 … 1

// A body in motion: the phase of its stride depends on the place alone, so equal frames are equal pictures.
vec3 moving(vec3 form, vec2 at, vec2 ahead, float scale) {
  vec2 d = (now.xy - before.xy) / 65535.0;
  float quick = smoothstep(0.0, 0.2 * radius, length((d - wrap.xy * floor(d + 0.5)) * size.xy));
  float stride = sin(6.2832 * dot(at, ahead) / (2.6 * scale) + (gait < 1.5 && form.x * form.y > 0.0 ? 3.1416 : 0.0));
  if (gait < 0.5) return form;
  if (gait < 1.5) form.x += 0.5 * quick * stride * max(0.0, -0.15 - form.z);
  else if (gait < 2.5) form.z += quick * stride * 0.45 * max(0.0, abs(form.y) - 0.3);
  else form.y += quick * stride * 0.22 * max(0.0, 0.3 - form.x);
  return form;
}

void main() {
  vec3 at = place();
  vOwn = followed.w * step(distance(at, followed.xyz), 0.25 * radius);
  float scale = scaled(at), h = heading(), c = cos(h), s = sin(h);
  float margin = rim * min(1.0, 1.5 * least * -(viewMatrix * vec4(at, 1.0)).z / (lens * scale)); // close up, rims are thinner
  vec3 form = moving(corner, at.xy, vec2(c, s), scale) * (1.0 + margin / max(0.3, length(corner)));
  mat3 turn = mat3(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
  vec3 light = turn * facing;
  float lit = min(tone, 1.0) * clamp(0.88 + 0.2 * max(0.0, dot(light, sun)) + 0.04 * light.z, 0.88, 1.06);
  vColour = through(rim > 0.0 ? edge * mix(0.75, 1.0, day) : mix(colour(at), vec3(1.0), clamp(tone - 1.0, 0.0, 1.0)) * lit, at);
  vStripes = vec2(9.0 * corner.x + 2.0 * corner.z, rim > 0.0 || abs(tone - 0.85) > 0.24 ? 0.0 : gene(floor(shown() / 256.0), striped, 0.0));
  vec4 seen = viewMatrix * vec4(at + turn * form * scale, 1.0);
  gl_Position = projectionMatrix * seen;
  if (rim > 0.0) {
    vec4 behind = projectionMatrix * (seen - vec4(0.0, 0.0, 2.5 * scale, 0.0));
    gl_Position.z = behind.z / behind.w * gl_Position.w;
  }
  gl_Position.z -= nearer * gl_Position.w;
}`;

/** A soft shadow below a body on land. */
export const SHADOW_VERTEX = /* glsl */ `
${COMMON}
${POSE}
attribute vec3 corner;
uniform vec3 sun;
varying vec2 vFrom;       // distance from the center, 1 at the edge

void main() {
  vec3 at = place();
  float scale = scaled(at), h = heading(), c = cos(h), s = sin(h);
  vFrom = corner.xy / vec2(1.9, 1.3);
  vec2 away = -0.6 * sun.xy / max(0.35, sun.z);
  gl_Position = projectionMatrix * viewMatrix * vec4(at + scale * vec3(mat2(c, s, -s, c) * corner.xy + away, corner.z), 1.0);
}`;

export const SHADOW_FRAGMENT = /* glsl */ `
${HIDES}
uniform float day;
varying vec2 vFrom;
void main() {
  if (hides()) discard;
  float dark = 0.42 * mix(0.6, 1.0, day) * (1.0 - smoothstep(0.25, 1.0, length(vFrom)));
  gl_FragColor = vec4(0.02, 0.05, 0.03, dark);
}`;

/** Capsules and boxes: a box enlarged on all sides by a rounding. */
export const SOLID_VERTEX = /* glsl */ `
${COMMON}
attribute vec3 corner;    // corner of the inner box: −1 or 1 along each axis; forward is +x
attribute vec3 facing;
attribute vec4 form;      // half length, half width, half height and rounding [m]
uniform vec3 sun;
varying float vOwn;
varying vec2 vStripes;

void main() {
  vec3 at = place();
  vOwn = 0.0, vStripes = vec2(0.0);
  vec4 centre = viewMatrix * vec4(at, 1.0);
  float most = max(form.x, max(form.y, form.z)) + form.w;
  float scale = max(1.0, least * -centre.z / lens / most) * entered();
  float h = heading(), c = cos(h), s = sin(h);
  mat3 turn = mat3(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
  vec3 light = turn * facing;
  float lit = 0.66 + 0.24 * dot(light, sun) + 0.16 * light.z;
  vColour = through(colour(at) * clamp(lit, 0.88, 1.06), at);
  gl_Position = projectionMatrix * viewMatrix * vec4(at + turn * (corner * form.xyz + facing * form.w) * scale, 1.0);
}`;

export const BODY_FRAGMENT = /* glsl */ `
${HIDES}
varying vec3 vColour;
varying float vOwn;
varying vec2 vStripes;
void main() {
  if (vOwn < 0.5 && hides()) discard;
  float soft = max(0.1, fwidth(vStripes.x)), pale = step(dot(vColour, vec3(0.3, 0.59, 0.11)), 0.42);
  float stripe = vStripes.y < 0.02 ? 0.0 : smoothstep(-soft, soft, sin(vStripes.x) - 1.0 + vStripes.y);
  gl_FragColor = vec4(mix(vColour, mix(0.35 * vColour, vec3(0.93), 0.75 * pale), stripe), 1.0);
}`;

/** Smooth noise, and the grain of ground seen from nearby, about 0. */
const NOISE = /* glsl */ `
uniform float grain;       // size of the largest grains [m]

float lot(vec2 p) { return fract(sin(dot(p, vec2(127.1, 311.7))) * 43758.5453); }

float patches(vec2 p) {
  vec2 low = floor(p), part = smoothstep(0.0, 1.0, p - low);
  return mix(mix(lot(low), lot(low + vec2(1.0, 0.0)), part.x), mix(lot(low + vec2(0.0, 1.0)), lot(low + 1.0), part.x), part.y);
}

float grains(vec2 at) {
  float sum = 0.0;
  for (float fine = 1.0; fine < 30.0; fine *= 5.0) {
    vec2 q = at * fine / grain;
    sum += (patches(q) - 0.5) * (1.0 - smoothstep(0.2, 0.9, length(fwidth(q))));
  }
  return sum;
}
`;

/** The walls of the water: light fades with depth. */
export const WATER_VERTEX = /* glsl */ `
varying vec3 vAt;
void main() {
  vAt = (modelMatrix * vec4(position, 1.0)).xyz;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

export const WATER_FRAGMENT = /* glsl */ `
varying vec3 vAt;
uniform float depth, murk, day;
uniform vec3 shallow, deep, night;
${NOISE}
void main() {
  float light = exp(-murk * max(0.0, depth - vAt.z));
  vec3 lit = mix(deep, shallow, light);
  vec3 colour = mix(night * (0.75 + 0.25 * light), lit, clamp(day, 0.0, 1.0));
  float bottom = step(vAt.z, 0.001 * depth) * (patches(vAt.xy / grain) - 0.5 + grains(2.0 * vAt.xy)); // the uneven bottom
  gl_FragColor = vec4(colour * (1.0 + 0.22 * bottom) + (lot(gl_FragCoord.xy) - 0.5) / 128.0, 1.0);
}`;

/** The surface of the water: a web of light, bright from below. */
export const SURFACE_FRAGMENT = /* glsl */ `
varying vec3 vAt;
uniform vec3 colour;
${NOISE}
void main() {
  vec2 q = vAt.xy / grain;
  float web = pow(1.0 - abs(2.0 * patches(1.1 * q + 0.9 * vec2(patches(0.8 * q), patches(0.8 * q + 17.0))) - 1.0), 4.0);
  gl_FragColor = vec4(colour, gl_FrontFacing ? 0.12 + 0.16 * web : 0.3 + 0.5 * web);
}`;

/** Shafts of light below the surface, which turn toward the camera. */
export const SHAFT_VERTEX = /* glsl */ `
attribute vec4 shaft;     // place at the surface and width, as shares of the world's size; brightness
uniform vec3 size;
varying vec3 vShaft;      // across −1 … 1; depth 0 … 1; brightness
void main() {
  vShaft = vec3(position.x, position.y, shaft.w);
  vec3 at = vec3(shaft.xy + vec2(0.18, 0.06) * position.y, 1.0 - position.y) * size;
  vec2 ahead = at.xy - cameraPosition.xy;
  at.xy += normalize(vec2(-ahead.y, ahead.x) + 1e-6) * position.x * shaft.z * (1.0 + position.y) * size.x;
  gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0);
}`;

export const SHAFT_FRAGMENT = /* glsl */ `
varying vec3 vShaft;
uniform vec3 colour;
uniform float day;
void main() {
  float across = 1.0 - vShaft.x * vShaft.x;
  gl_FragColor = vec4(colour, 0.34 * day * vShaft.z * across * across * exp(-1.8 * vShaft.y) * (1.0 - vShaft.y));
}`;

/** Flat ground with soft patches; beyond the world's edges it fades. */
export const LAND_FRAGMENT = /* glsl */ `
varying vec3 vAt;
uniform vec2 size;
uniform vec3 grassy, bare;
uniform float beyond;      // brightness of the land around the world
${NOISE}

void main() {
  float span = max(size.x, size.y);
  vec2 p = vAt.xy / span, beside = max(abs(vAt.xy - 0.5 * size) - 0.5 * size, 0.0) / span;
  float tint = 0.55 * patches(9.0 * p) + 0.3 * patches(31.0 * p) + 0.15 * patches(140.0 * p), away = length(beside);
  vec3 shade = mix(grassy, bare, smoothstep(0.25, 0.75, tint)) * mix(1.0, beyond * (0.94 + 0.12 * tint), step(1e-5, away)) * (1.0 + 0.07 * grains(vAt.xy));
  gl_FragColor = vec4(shade, 1.0 - smoothstep(0.15, 3.2, away));
}`;

/** Hills, added to a material of three.js: patches, grain and, by land cover, treetops, furrowed fields and rock. */
export const SOIL = /* glsl */ `
varying vec2 vOver;        // [m]
uniform vec2 size;
uniform sampler2D cover;   // 1 woods, 2 crops, 3 rock, 4 water
${NOISE}
// The brightness of treetops, lit from one side, each at a place and of a size of its own.
float crown(vec2 q) {
  vec2 place = floor(q), off = fract(q) - 0.5 - 0.45 * (vec2(lot(place), lot(place + 9.0)) - 0.5);
  float wide = 0.26 + 0.14 * lot(place + 3.0);
  return mix(0.5, 0.58 + 0.22 * lot(place + 7.0) - 0.5 * (off.x - off.y), 1.0 - smoothstep(wide - 0.1, wide, length(off)));
}

vec3 textured(vec3 own) {
  float span = max(size.x, size.y), unit = max(2.0 * grain, span / 250.0);
  vec2 p = vOver / span, stray = vec2(patches(1.3 * vOver / unit), patches(1.3 * vOver / unit + 37.0)) - 0.5;
  float kind = floor(255.0 * texture2D(cover, (vOver + unit * stray) / size).r + 0.5);
  float tint = patches(9.0 * p) + 0.6 * patches(31.0 * p) + 0.4 * patches(140.0 * p) - 1.0;
  float bright = dot(own, vec3(0.3, 0.59, 0.11));
  if (kind >= 1.0 && kind < 4.0) own = mix(own, bright * (kind == 1.0 ? vec3(0.6, 1.15, 0.62) : kind == 2.0 ? vec3(1.35, 1.05, 0.5) : vec3(1.02, 1.0, 1.0)), 0.6); // green woods, yellow crops, gray rock
  if (kind == 1.0) {
    vec2 q = 2.6 * vOver / unit + 1.2 * stray;
    float far = smoothstep(0.3, 0.9, length(fwidth(q)));
    return own * mix(max(crown(q), crown(mat2(0.76, 0.74, -0.7, 0.8) * q)), 0.68, far) * (1.0 + 0.08 * tint);
  }
  if (kind == 2.0) {
    vec2 lots = floor((vOver + 0.3 * unit * stray) / (9.0 * unit));
    float turn = 3.14 * lot(lots), row = dot(vOver, vec2(cos(turn), sin(turn))) * 16.0 / unit;
    return own * (0.86 + 0.24 * lot(lots + 5.0)) * (1.0 + 0.12 * sin(row) * (1.0 - smoothstep(0.8, 2.5, fwidth(row))));
  }
  if (kind == 3.0) return own * (0.8 + 0.5 * abs(patches(1.7 * vOver / unit) + 0.5 * patches(5.0 * vOver / unit) - 0.75));
  if (kind == 4.0) return own * (1.0 + 0.05 * tint);
  return own * (1.0 + 0.13 * tint + 0.13 * grains(vOver));
}
`;

/** A lake: darker toward the middle, with a bright shore and ripples. */
export const LAKE_FRAGMENT = /* glsl */ `
varying vec3 vAt;
uniform vec3 colour;
uniform vec4 round;        // center and radius [m]
${NOISE}
void main() {
  float away = length(vAt.xy - round.xy) / round.z;
  vec2 q = vAt.xy * vec2(0.7, 2.6) / grain;
  float ripples = smoothstep(0.62, 0.8, patches(0.35 * q + patches(0.1 * q))) * (1.0 - smoothstep(0.3, 1.2, 0.35 * length(fwidth(q))));
  vec3 deep = colour * mix(1.1, 0.78, smoothstep(1.0, 0.5, away + 0.12 * patches(vAt.xy * 8.0 / round.z)));
  gl_FragColor = vec4(deep * (1.0 + 0.16 * ripples) + 0.14 * smoothstep(0.975, 1.0, away), 0.94);
}`;
