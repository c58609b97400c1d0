/**
 * Lines of some width on the page, as one mesh of upright quads in the picture.
 *
 * The lines of three.js draw an instance for each stretch, and software rendering takes each instance for a drawing of
 * its own: hundreds of stretches cost more than all the rest of the scene.
 */

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  InterleavedBuffer,
  InterleavedBufferAttribute,
  Mesh,
  ShaderMaterial,
  Vector2,
  Vector4,
  type WebGLRenderer,
} from "three";

/** Numbers of a point, and of a stretch: its four corners have both its ends. */
const POINT = 3;
const CORNERS = 4;
/** Corners of the two triangles of a stretch, counter-clockwise in the picture. */
const TRIANGLES = [0, 2, 1, 1, 2, 3];

/** Corners 0 and 1 are at the first end, 2 and 3 at the second, to both sides; the ends reach half the width further. */
const VERTEX = /* glsl */ `
attribute vec3 second;
uniform vec2 page;
uniform float width;
void main() {
  vec4 a = modelViewMatrix * vec4(position, 1.0);
  vec4 b = modelViewMatrix * vec4(second, 1.0);
  // What is behind the eye has no place in the picture: such stretches begin before it.
  float near = -2e-3;
  if (a.z > near && b.z < near) a = mix(b, a, (near - b.z) / (a.z - b.z));
  else if (b.z > near && a.z < near) b = mix(a, b, (near - a.z) / (b.z - a.z));
  vec4 from = projectionMatrix * a;
  vec4 to = projectionMatrix * b;
  vec2 way = (to.xy / to.w - from.xy / from.w) * page;
  way = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
  bool late = gl_VertexID % 4 > 1;
  float side = gl_VertexID % 2 == 0 ? -1.0 : 1.0;
  gl_Position = late ? to : from;
  gl_Position.xy += (late ? way : -way) * width / page * gl_Position.w;
  gl_Position.xy += side * vec2(-way.y, way.x) * width / page * gl_Position.w;
}`;
const FRAGMENT = /* glsl */ `
uniform vec3 ink;
void main() {
  gl_FragColor = vec4(ink, 1.0);
  #include <colorspace_fragment>
}`;

const view = new Vector4();

/** A line through points, x, y, z [m] of one after the other, so wide [px]; seen through everything or not. */
export function ribbon(
  numbers: number[],
  width: number,
  { color, through }: { color: string; through: boolean },
): Mesh {
  const uniforms = { page: { value: new Vector2(1, 1) }, width: { value: width }, ink: { value: new Color(color) } };
  const material = new ShaderMaterial({
    uniforms,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    depthTest: !through,
    depthWrite: false,
    transparent: true,
  });
  const made = new Mesh(stretches(numbers), material);
  made.frustumCulled = false;
  made.onBeforeRender = (renderer: WebGLRenderer) => {
    renderer.getViewport(view);
    uniforms.page.value.set(view.z, view.w);
    material.uniformsNeedUpdate = true;
  };
  return made;
}

/** The corners of the stretches between points. */
function stretches(numbers: number[]): BufferGeometry {
  const count = Math.max(numbers.length / POINT - 1, 0);
  const ends = new Float32Array(2 * POINT * CORNERS * count);
  const index = new Uint32Array(TRIANGLES.length * count);
  for (let k = 0; k < count; k++) {
    const both = numbers.slice(POINT * k, POINT * (k + 2));
    for (let corner = CORNERS * k; corner < CORNERS * (k + 1); corner++) ends.set(both, 2 * POINT * corner);
    for (let j = 0; j < TRIANGLES.length; j++) index[TRIANGLES.length * k + j] = CORNERS * k + (TRIANGLES[j] ?? 0);
  }
  const rows = new InterleavedBuffer(ends, 2 * POINT);
  return new BufferGeometry()
    .setIndex(new BufferAttribute(index, 1))
    .setAttribute("position", new InterleavedBufferAttribute(rows, POINT, 0))
    .setAttribute("second", new InterleavedBufferAttribute(rows, POINT, POINT));
}
