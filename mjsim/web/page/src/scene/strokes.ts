/** Points that are seen well from near and far, also while few pixels are drawn. */

import { type BufferGeometry, Points, PointsMaterial } from "three";

/** Across a point at least, of half the height of the view. */
export const LEAST = 0.009;
/** By which points that lie on a surface are drawn before it, of the depth that there is. */
const BEFORE = 1e-4;

/** How points are drawn. */
export interface Ink {
  color: string;
  /** Whether it is seen through everything. */
  through?: boolean;
}

/** Round points, so large [m], and at least so large in the picture [of half its height]. */
export function dots(
  places: BufferGeometry,
  size: number,
  { color, through = false }: Ink,
  least = LEAST,
): Points<BufferGeometry, PointsMaterial> {
  const material = new PointsMaterial({ color, size, depthTest: !through, depthWrite: false, transparent: true });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace(
      "#include <logdepthbuf_vertex>",
      `gl_PointSize = max(gl_PointSize, max(1.0, ${least.toFixed(4)} * scale)); gl_Position.z -= ${BEFORE} * gl_Position.w;
      #include <logdepthbuf_vertex>`,
    );
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <clipping_planes_fragment>",
      "if (length(gl_PointCoord - 0.5) > 0.5) discard;\n#include <clipping_planes_fragment>",
    );
  };
  material.customProgramCacheKey = () => `dots ${least}`;
  return new Points(places, material);
}
