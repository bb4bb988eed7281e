// One draw call shows all patches: a vertex is corner gl_VertexID % 4 of patch gl_VertexID / 4, whose values lie in a
// texture, four texels a patch. Interpolation is that of crates/geometry/src/corners.rs: bilinear on quads, linear on
// triangles.

export const VERTEX = /* glsl */ `
precision highp float;
precision highp int;
uniform mat4 modelViewMatrix, projectionMatrix;
in vec3 position;
out vec2 st;
flat out int patchIndex;

void main() {
  int corner = gl_VertexID & 3;
  patchIndex = gl_VertexID >> 2;
  st = vec2(corner == 1 || corner == 2, corner >= 2);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}
`;

/** What the fragment shader makes of a value. */
export const LOOK = { developed: 0, falseColours: 1, plain: 2, linear: 3 } as const;

export const FRAGMENT = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D values;     // r, g, b; a is 1 on triangles
uniform sampler2D colours;    // of the scale
uniform int look;             // LOOK
uniform int curve;            // 0 filmic, 1 linear, 2 reinhard
uniform float exposure;       // a factor
uniform vec3 weights;         // from bands to the scalar that false colours show
uniform vec3 scale;           // first value, last value, 1 if logarithmic
uniform float isolines;       // distance of two lines, in the scalar; in decades if logarithmic; 0 for none
uniform float mesh;           // opacity of the edges of patches
uniform ivec2 chosen;         // a patch that is marked, or -1; and its strength in percent
in vec2 st;
flat in int patchIndex;
out vec4 colour;

vec4 corner(int k) {
  int at = 4 * patchIndex + k, width = textureSize(values, 0).x;
  return texelFetch(values, ivec2(at % width, at / width), 0);
}

vec3 curved(vec3 x) {
  x = clamp(x, 0.0, 1e6);
  float l = dot(x, vec3(0.2126, 0.7152, 0.0722));
  if (curve == 0) x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  if (curve == 2) x = x * (1.0 + l / 16.0) / (1.0 + l);
  return clamp(x, 0.0, 1.0);
}

vec3 srgb(vec3 x) {
  return mix(12.92 * x, 1.055 * pow(max(x, 1e-9), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

// A line along a side of a patch, one pixel on each of two patches; where patches are small it fades.
float line(float distance_) {
  float pixel = fwidth(distance_);
  return (1.0 - smoothstep(0.3 * pixel, 1.1 * pixel, abs(distance_))) * (1.0 - smoothstep(0.1, 0.35, pixel));
}

void main() {
  vec4 first = corner(0);
  bool isTriangle = first.a > 0.5;
  vec2 at = clamp(st, 0.0, 1.0); // pixels that a patch covers in part may have their middle beside it
  vec4 weight = isTriangle
    ? vec4(1.0 - at.x, at.x - at.y, at.y, 0.0)
    : vec4((1.0 - at.x) * (1.0 - at.y), at.x * (1.0 - at.y), at.x * at.y, (1.0 - at.x) * at.y);
  vec3 value = weight.x * first.rgb + weight.y * corner(1).rgb + weight.z * corner(2).rgb + weight.w * corner(3).rgb;
  if (look == 3) { colour = vec4(value, 1.0); return; }

  float scalar = dot(weights, value);
  bool isLogarithmic = scale.z > 0.5;
  float measure = isLogarithmic ? log2(max(scalar, 1e-30)) * 0.30103 : scalar;
  vec2 ends = isLogarithmic ? log2(max(scale.xy, vec2(1e-30))) * 0.30103 : scale.xy;
  if (look == 1) {
    float t = clamp((measure - ends.x) / max(ends.y - ends.x, 1e-30), 0.0, 1.0);
    colour.rgb = texture(colours, vec2((255.0 * t + 0.5) / 256.0, 0.5)).rgb;
  } else {
    colour.rgb = srgb(look == 0 ? curved(exposure * value) : clamp(value, 0.0, 1.0));
  }
  if (isolines > 0.0) {
    float count = measure / isolines, pixel = fwidth(count);
    float near = abs(fract(count + 0.5) - 0.5);
    float on = 1.0 - smoothstep(0.3 * pixel, 1.2 * pixel, near);
    // Where lines would run together they fade.
    colour.rgb = mix(colour.rgb, vec3(look == 1 ? 1.0 : 0.0), 0.8 * on * (1.0 - smoothstep(0.3, 0.6, pixel)));
  }
  if (mesh > 0.0) {
    float edge = max(line(st.y), line(1.0 - st.x));
    edge = max(edge, isTriangle ? line(st.x - st.y) : max(line(st.x), line(1.0 - st.y)));
    float bright = dot(colour.rgb, vec3(0.3, 0.6, 0.1));
    colour.rgb = mix(colour.rgb, vec3(bright > 0.5 ? 0.0 : 1.0), mesh * edge);
  }
  if (chosen.x == patchIndex) colour.rgb = mix(colour.rgb, vec3(1.0, 0.6, 0.1), 0.01 * float(chosen.y));
  colour.a = 1.0;
}
`;
