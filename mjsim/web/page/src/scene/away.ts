/** What events have taken away is not drawn, nor picked, until it is back. */

import { type BufferGeometry, Mesh, type Object3D } from "three";
import { thingsOf } from "./solids";

/** Take these beacons and obstacles out of a scene, by their names, and bring all others back. */
export function takeAway(root: Object3D, names: string[]): void {
  const own = names.flatMap((name) => [`obstacle/${name}`, `beacon/${name}`]);
  const isAway = (thing: string): boolean =>
    own.some((each) => thing === each || thing.startsWith(`${each}/`) || thing.startsWith(`${each}:`));
  root.traverse((object) => object instanceof Mesh && leaveOut(object, isAway));
}

/** Draw the triangles of some things as none; faces keep their numbers, by which things are picked. */
function leaveOut(mesh: Mesh, isAway: (thing: string) => boolean): void {
  const index = (mesh.geometry as BufferGeometry).getIndex();
  if (!index) return;
  const whole = (mesh.userData["whole"] ??= index.array.slice()) as typeof index.array;
  const drawn = whole.slice();
  let first = 0;
  for (const [thing, count] of thingsOf(mesh)) {
    if (isAway(thing)) drawn.fill(0, 3 * first, 3 * (first + count));
    first += count;
  }
  index.array.set(drawn);
  index.needsUpdate = true;
}
