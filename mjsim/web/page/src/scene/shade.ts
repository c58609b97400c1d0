/** Pictures with ambient occlusion, contact shadows and, on demand, edges: computed from the depth of what was drawn. */

import {
  DepthTexture,
  GLSL3,
  HalfFloatType,
  type IUniform,
  Mesh,
  NearestFilter,
  OrthographicCamera,
  type PerspectiveCamera,
  PlaneGeometry,
  RawShaderMaterial,
  Scene,
  Vector2,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import CORNERS from "./corners.glsl";
import OCCLUSION from "./occlusion.glsl";
import PICTURE from "./picture.glsl";

/** How far things darken each other, as a share of the height of the picture. */
const REACH = 0.045;
/** How much less light reaches a corner; where light is baked, it is darker there already. */
const DARKEST = 1.6;
const DARKEST_BAKED = 0.5;

/** Draws a scene, then looks at the depth of the picture. */
export class Shade {
  /** Whether edges are drawn. */
  edges = false;
  /** Whether the colours of the scene include its light. */
  isBaked = false;
  private readonly drawn: WebGLRenderTarget;
  private readonly open = new WebGLRenderTarget(1, 1, {
    depthBuffer: false,
    minFilter: NearestFilter,
    magFilter: NearestFilter,
  });
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
    this.occlusion = pass(OCCLUSION, {
      depth,
      pixel: this.pixel,
      unproject: { value: null },
      project: { value: null },
      reach: { value: REACH },
    });
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
    (planes?.value as Vector2 | undefined)?.set(eye.near, eye.far);
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
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: CORNERS,
    fragmentShader,
    uniforms,
    depthTest: false,
    depthWrite: false,
  });
}
