// Alchemy ambient obscurance (McGuire et al. 2011), with normals from the depths of the nearer neighbours.
precision highp float;
uniform sampler2D depth;
uniform vec2 pixel;
in vec2 at;
out vec4 told;

uniform mat4 unproject;
uniform mat4 project;
uniform float reach;
const int TAPS = 12;
vec3 placeAt(vec2 uv) {
  vec4 p = unproject * vec4(2.0 * vec3(uv, texture(depth, uv).x) - 1.0, 1.0);
  return p.xyz / p.w;
}
vec3 smaller(vec3 a, vec3 b) { return abs(a.z) < abs(b.z) ? a : b; }
void main() {
  told = vec4(1.0);
  if (texture(depth, at).x >= 1.0) return;
  vec3 p = placeAt(at);
  vec3 right = smaller(placeAt(at + vec2(pixel.x, 0.0)) - p, p - placeAt(at - vec2(pixel.x, 0.0)));
  vec3 up = smaller(placeAt(at + vec2(0.0, pixel.y)) - p, p - placeAt(at - vec2(0.0, pixel.y)));
  vec3 normal = normalize(cross(right, up));
  float radius = 2.0 * reach * -p.z / project[1][1];
  // Interleaved gradient noise (Jimenez 2014): a block of 4 x 4 pixels looks into all directions.
  float turn = 6.2832 * fract(52.9829189 * fract(dot(floor(gl_FragCoord.xy), vec2(0.06711056, 0.00583715))));
  float hidden = 0.0;
  for (int k = 0; k < TAPS; k++) {
    float far = (float(k) + 0.5) / float(TAPS);
    float angle = turn + 2.399963 * float(k);
    vec2 uv = at + reach * far * vec2(cos(angle) * pixel.x / pixel.y, sin(angle));
    vec3 way = placeAt(uv) - p;
    float height = dot(way, normal) - 0.02 * radius;
    hidden += max(0.0, height) * radius / (dot(way, way) + 0.02 * radius * radius) * step(length(way), 3.0 * radius);
  }
  told = vec4(clamp(1.0 - 0.6 * hidden / float(TAPS), 0.0, 1.0));
}
