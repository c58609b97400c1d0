// On a plane the depth is linear across the picture: where its second difference is not zero, there is an edge.
precision highp float;
uniform sampler2D depth;
uniform vec2 pixel;
in vec2 at;
out vec4 told;

uniform sampler2D colors;
uniform sampler2D open;
uniform float darkest;
uniform float edges;
uniform vec2 planes;
// Not by mix(), which may round to 0 where nothing was drawn: planes of a robot's camera are a centimetre and 2000 km.
float nearness(vec2 uv) {
  float d = texture(depth, uv).x;
  return (1.0 - d) / planes.x + d / planes.y;
}
float bend(float middle, vec2 by) {
  return abs(nearness(at + by) + nearness(at - by) - 2.0 * middle) / (middle * 2.0 * pixel.y);
}
void main() {
  float sum = 0.0;
  float share = 0.0;
  float middle = nearness(at);
  for (int x = -2; x < 2; x++) for (int y = -2; y < 2; y++) {
    vec2 uv = at + (vec2(x, y) + 0.5) * pixel;
    // What lies elsewhere has other light.
    float same = 1.0 / (1e-4 + abs(nearness(uv) / middle - 1.0));
    sum += same * texture(open, uv).x;
    share += same;
  }
  vec4 color = texture(colors, at);
  color.rgb *= pow(sum / share, darkest);
  float edge = edges * smoothstep(0.25, 0.6, max(bend(middle, vec2(pixel.x, 0.0)), bend(middle, vec2(0.0, pixel.y))));
  color.rgb = mix(color.rgb, color.rgb * 0.15, edge);
  vec3 low = 12.92 * color.rgb;
  vec3 high = 1.055 * pow(max(color.rgb, 0.0031308), vec3(1.0 / 2.4)) - 0.055;
  told = vec4(mix(high, low, vec3(lessThanEqual(color.rgb, vec3(0.0031308)))), 1.0);
}
