/** A light from nearly above all things: what stands darkens the floor beside it. */

import { type Box3, DirectionalLight, Sphere, Vector3 } from "three";

const FROM = new Vector3(0.12, 0.2, 1).normalize();

export class Sky extends DirectionalLight {
  /** Its shadows have so many cells to a side. */
  constructor(private readonly cells: number) {
    super("white", 0.8);
    this.shadow.mapSize.setScalar(cells);
    this.shadow.radius = 4;
    this.shadow.bias = -0.0005;
  }

  /** Stand over all things in a box. */
  over(box: Box3): void {
    const { center, radius } = box.getBoundingSphere(new Sphere());
    this.target.position.copy(center);
    this.position.copy(center).addScaledVector(FROM, 2 * radius);
    const { camera } = this.shadow;
    Object.assign(camera, {
      left: -radius,
      right: radius,
      top: radius,
      bottom: -radius,
      near: radius,
      far: 3.1 * radius,
    });
    camera.updateProjectionMatrix();
    // Two cells [m].
    this.shadow.normalBias = (4 * radius) / this.cells;
  }
}
