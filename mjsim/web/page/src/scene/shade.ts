/** Pictures with ambient occlusion, contact shadows and, on demand, edges: computed from the depth of what was drawn. */

import {
  DepthTexture,
  GLSL3,
  HalfFloatType,
  Mesh,
  NearestFilter,
  OrthographicCamera,
  PlaneGeometry,
  RawShaderMaterial,
  Scene,
  Vector2,
  WebGLRenderTarget,
  type IUniform,
  type PerspectiveCamera,
  type WebGLRenderer,
} from "three";

/** How far things darken each other, as a share of the height of the picture. */
const REACH = 0.045;
/** How much less light reaches a corner; where light is baked, it is darker there already. */
const DARKEST = 1.6;
const DARKEST_BAKED = 0.5;

const CORNERS = `in vec3 position; out vec2 at; void main() { at = 0.5 + 0.5 * position.xy; gl_Position = vec4(position, 1.0); }`;

const DEPTH = `
precision highp float;
uniform sampler2D depth;
uniform vec2 pixel;
in vec2 at;
out vec4 told;
`;

/** Alchemy ambient obscurance (McGuire et al. 2011), with normals from the depths of the nearer neighbours. */
const OCCLUSION = `${DEPTH}
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
}`;

/** On a plane the depth is linear across the picture: where its second difference is not zero, there is an edge. */
const PICTURE = `${DEPTH}
uniform sampler2D colors;
uniform sampler2D open;
uniform float darkest;
uniform float edges;
uniform vec2 planes;
float nearness(vec2 uv) { return mix(1.0 / planes.x, 1.0 / planes.y, texture(depth, uv).x); }
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
}`;

/** Draws a scene, then looks at the depth of the picture. */
export class Shade {
  /** Whether edges are drawn. */
  edges = false;
  /** Whether the colours of the scene include its light. */
  isBaked = false;
  private readonly drawn: WebGLRenderTarget;
  private readonly open = new WebGLRenderTarget(1, 1, { depthBuffer: false, minFilter: NearestFilter, magFilter: NearestFilter });
  private readonly pixel = { value: new Vector2() };
  private readonly occlusion: RawShaderMaterial;
  private readonly picture: RawShaderMaterial;
  private readonly sheet = new Mesh(new PlaneGeometry(2, 2));
  private readonly table = new Scene().add(this.sheet);
  private readonly flat = new OrthographicCamera();

  constructor(samples: number) {
    this.drawn = new WebGLRenderTarget(1, 1, { type: HalfFloatType, samples, depthTexture: new DepthTexture(1, 1) });
    const depth = { value: this.drawn.depthTexture };
    this.sheet.frustumCulled = false;
    this.occlusion = pass(OCCLUSION, { depth, pixel: this.pixel, unproject: { value: null }, project: { value: null }, reach: { value: REACH } });
    const [colors, open] = [{ value: this.drawn.texture }, { value: this.open.texture }];
    const numbers = { darkest: { value: DARKEST }, edges: { value: 0 }, planes: { value: new Vector2() } };
    this.picture = pass(PICTURE, { depth, pixel: this.pixel, colors, open, ...numbers });
  }

  render(renderer: WebGLRenderer, scene: Scene, eye: PerspectiveCamera): void {
    this.fit(renderer);
    renderer.setRenderTarget(this.drawn);
    renderer.render(scene, eye);
    Object.assign(this.occlusion.uniforms["unproject"] ?? {}, { value: eye.projectionMatrixInverse });
    Object.assign(this.occlusion.uniforms["project"] ?? {}, { value: eye.projectionMatrix });
    this.lay(renderer, this.occlusion, this.open);
    const { darkest, edges, planes } = this.picture.uniforms as Record<string, IUniform>;
    if (darkest) darkest.value = this.isBaked ? DARKEST_BAKED : DARKEST;
    if (edges) edges.value = Number(this.edges);
    (planes?.value as Vector2).set(eye.near, eye.far);
    this.lay(renderer, this.picture, null);
  }

  private lay(renderer: WebGLRenderer, material: RawShaderMaterial, on: WebGLRenderTarget | null): void {
    this.sheet.material = material;
    renderer.setRenderTarget(on);
    renderer.render(this.table, this.flat);
  }

  private fit(renderer: WebGLRenderer): void {
    const { x, y } = renderer.getDrawingBufferSize(new Vector2());
    if (this.drawn.width === x && this.drawn.height === y) return;
    this.drawn.setSize(x, y);
    this.open.setSize(x, y);
    this.pixel.value.set(1 / x, 1 / y);
  }
}

function pass(fragmentShader: string, uniforms: Record<string, IUniform>): RawShaderMaterial {
  return new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: CORNERS, fragmentShader, uniforms, depthTest: false, depthWrite: false });
}
