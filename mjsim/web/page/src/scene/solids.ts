/** The scene as the server gives it: glTF, drawn with simple light, and the nodes of its bodies in their order. */

import {
  Box3,
  type BufferAttribute,
  type BufferGeometry,
  Camera,
  Group,
  type Material,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  type MeshStandardMaterial,
  type Object3D,
  type Texture,
  TextureLoader,
  Vector3,
} from "three";
import { type GLTF, GLTFLoader, type GLTFParser } from "three/addons/loaders/GLTFLoader.js";

/** Bytes before the poses: time [s], how many bodies, how many contacts. */
const HEAD = 16;
/** Numbers of 4 bytes of one body: x, y, z, and a quaternion; of a contact: x, y, z, and whether it is with the floor. */
const ROW = 7;
const CONTACT = 4;

/** What a moment has beside the places of bodies. */
export interface Moment {
  /** [s] */
  time: number;
  /** Rows of x, y, z [m], and 1 for the floor. */
  contacts: Float32Array;
  /** Names of what events have taken away. */
  removed: string[];
}

export interface Solids {
  /** Holds all, z up. */
  root: Group;
  /** Each body, what stands still first. */
  bodies: Object3D[];
  /** What is aboard robots, by its name. */
  cameras: Map<string, Camera>;
}

/** Read a scene. Raises Error when it is none. */
export async function readSolids(data: ArrayBuffer): Promise<Solids> {
  const loader = new GLTFLoader();
  // As elements of the page: the page may not fetch what it made itself.
  loader.register((parser: GLTFParser) => {
    (parser as unknown as { textureLoader: TextureLoader }).textureLoader = new TextureLoader();
    return { name: "pictures" };
  });
  const gltf: GLTF = await loader.parseAsync(data, "");
  const root = new Group();
  const turned = gltf.scene.children[0];
  if (!turned) throw new Error("the scene has no root");
  const bodies = [...turned.children];
  root.add(...bodies);
  root.traverse((object) => object instanceof Mesh && plain(object));
  const cameras = new Map<string, Camera>();
  root.traverse((object) => object instanceof Camera && cameras.set(String(object.userData["name"]), object));
  return { root, bodies, cameras };
}

/** Put the bodies where they are at a moment, and return what else there is of it. */
export function pose(solids: Solids, data: ArrayBuffer): Moment {
  const head = new DataView(data);
  const [bodies, touching] = [head.getUint32(8, true), head.getUint32(12, true)];
  const numbers = new Float32Array(data, HEAD, ROW * bodies + CONTACT * touching);
  solids.bodies.slice(0, bodies).forEach((body, k) => {
    body.position.fromArray(numbers, ROW * k);
    body.quaternion.fromArray(numbers, ROW * k + 3);
  });
  const names = new TextDecoder().decode(new Uint8Array(data, HEAD + numbers.byteLength));
  return {
    time: head.getFloat64(0, true),
    contacts: numbers.subarray(ROW * bodies),
    removed: JSON.parse(names) as string[],
  };
}

/** Give back what the graphics card holds of it. */
export function dispose(solids: Solids): void {
  solids.root.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    (object.geometry as BufferGeometry).dispose();
    const material = object.material as MeshLambertMaterial;
    material.map?.dispose();
    material.dispose();
  });
}

/** The name of the geom that a triangle of a mesh belongs to. */
export function thingOf(mesh: Mesh, triangle: number): string {
  let left = triangle;
  for (const [name, count] of thingsOf(mesh)) {
    if (left < count) return name;
    left -= count;
  }
  return "";
}

/** The names of the geoms in a mesh, with how many triangles each has. */
export function thingsOf(mesh: Mesh): [string, number][] {
  return ((mesh.geometry as BufferGeometry).userData["things"] ?? []) as [string, number][];
}

/** The box around what stands on the floor; around the floor where nothing does. */
export function boxOfThings(root: Object3D): Box3 {
  const [things, all] = [new Box3(), new Box3().setFromObject(root)];
  root.updateMatrixWorld();
  root.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    const { userData } = object.geometry as BufferGeometry;
    userData["box"] ??= ownBoxOfThings(object);
    const box = userData["box"] as Box3;
    if (!box.isEmpty()) things.union(box.clone().applyMatrix4(object.matrixWorld));
  });
  return things.isEmpty() ? all : things;
}

/** The box of a mesh without the floor, in its own frame. */
function ownBoxOfThings(mesh: Mesh): Box3 {
  const { attributes, index } = mesh.geometry as BufferGeometry;
  const [box, at] = [new Box3(), new Vector3()];
  let next = 0;
  for (const [name, count] of thingsOf(mesh)) {
    const end = next + 3 * count;
    if (/^floor(\/|$)/.test(name)) next = end;
    for (; next < end; next++)
      box.expandByPoint(at.fromBufferAttribute(attributes["position"] as BufferAttribute, index?.getX(next) ?? next));
  }
  return box;
}

/** How many geoms a scene has. */
export function countThings(root: Object3D): number {
  let count = 0;
  root.traverse((object) => {
    if (object instanceof Mesh) count += thingsOf(object).length;
  });
  return count;
}

/** Replace the costly material of glTF by one without gloss; colours that include the light are left as they are. */
function plain(mesh: Mesh): void {
  const given = mesh.material as MeshStandardMaterial | MeshBasicMaterial;
  const map: Texture | null = given.map;
  const Kind = given instanceof MeshBasicMaterial ? MeshBasicMaterial : MeshLambertMaterial;
  const made: Material = new Kind({
    map,
    vertexColors: true,
    transparent: given.transparent,
    depthWrite: !given.transparent,
  });
  given.dispose();
  mesh.material = made;
}
