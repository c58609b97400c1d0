"""Compute the light at each pixel of views with Mitsuba; `light.py` starts it with an interpreter that has Mitsuba.

python light_traced.py SCENE.npz RESULT.npy SAMPLES

The result has, for each view, the light on the surface in each pixel, relative to full light, red, green and blue, and
1 where it counts, shape (views, height, width, 4). Noise is averaged over pixels of one surface.
"""

import sys
from functools import cache

import mitsuba as mi
import numpy as np

GAMMA = 2.2
MEAN_OVER = 3
"""Half the side of the square over which noise is averaged [px]."""
AT_ONCE = 8
"""Rays of a pixel that are followed together, to bound memory."""


def textured(points, places, surface, glow, name):
    """Return triangles of a surface."""
    properties = mi.Properties()
    properties["bsdf"] = surface
    if glow is not None and glow.max() > 0.0:
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(glow)})
    count = len(points)
    mesh = mi.Mesh(name, count, count // 3, has_vertex_texcoords=places is not None, props=properties)
    values = mi.traverse(mesh)
    values["vertex_positions"] = points.ravel().astype(np.float32)
    values["faces"] = np.arange(count, dtype=np.uint32)
    if places is not None:
        values["vertex_texcoords"] = places.ravel().astype(np.float32)
    values.update()
    return mesh


@cache
def diffuse(albedo):
    """Return a diffuse surface of an even colour, red, green, blue; one for all that have it."""
    return mi.load_dict({"type": "diffuse", "reflectance": rgb(albedo)})


def pictured(picture, albedo):
    """Return a diffuse surface with a picture that has a mean colour."""
    picture = (picture / 255.0) ** GAMMA
    share = np.array(albedo) / np.maximum(picture.reshape(-1, 3)[::17].mean(axis=0), 1e-6)
    bitmap = mi.Bitmap(np.ascontiguousarray(picture * share, dtype=np.float32))
    return mi.load_dict({"type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": bitmap, "raw": True}})


def rgb(values):
    """Return a colour of Mitsuba."""
    return {"type": "rgb", "value": [float(value) for value in values]}


def scene_of(file):
    """Return the scene."""
    parts, surfaces = {"type": "scene"}, {}
    for key in file.files:
        kind, number = key.rstrip("0123456789"), key.lstrip("abcdefghijklmnopqrstuvwxyz")
        if kind == "points":
            albedo, places = tuple(file[f"albedo{number}"].tolist()), None
            if f"texture{number}" in file:
                look = int(file[f"texture{number}"]), albedo
                if look not in surfaces:
                    surfaces[look] = pictured(file[f"picture{look[0]}"], albedo)
                surface, places = surfaces[look], file[f"places{number}"]
            else:
                surface = diffuse(albedo)
            parts[key] = textured(file[key], places, surface, file[f"glow{number}"], key)
        if kind == "lamp":
            middle, across, along, radiance = file[key]
            corners = np.array([middle - across - along, middle + across - along, middle + across + along])
            square = np.concatenate([corners, corners[[0, 2]], [middle - across + along]])
            parts[key] = textured(square, None, diffuse((0.0, 0.0, 0.0)), radiance, key)
    sky = np.zeros((64, 128, 3), np.float32)
    sky[:32] = file["sky"]
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    parts["sky"] = {"type": "envmap", "bitmap": mi.Bitmap(sky), "to_world": upright}
    return mi.load_dict(parts)


def rays_of(view, width, height, fov, samples):
    """Return rays through the middles of all pixels, `samples` of each, as MuJoCo samples a picture."""
    x, y, z, heading = view.tolist()
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    rows, columns = np.mgrid[0:height, 0:width].reshape(2, -1).repeat(samples, axis=1)
    step = 2 * np.tan(np.radians(fov / 2)) / width
    right, up = step * (columns + 0.5 - width / 2), step * (height / 2 - rows - 0.5)
    directions = np.stack([c + s * right, s - c * right, up])
    directions /= np.linalg.norm(directions, axis=0)
    return mi.RayDifferential3f(mi.Point3f(x, y, z), mi.Vector3f(directions.astype(np.float32)))


def light_of(scene, view, size, bounces, samples, seed):
    """Return the light in each pixel, and where it counts."""
    (width, height), fov = size[:2].astype(int), size[2]
    rays = rays_of(view, width, height, fov, 1)
    at = scene.ray_intersect(rays)
    seen, bsdf = at.is_valid(), at.bsdf(rays)
    albedo = np.array(bsdf.eval_diffuse_reflectance(at, seen)).T
    counts = np.array(seen) & (albedo.min(axis=1) > 1e-3)
    radiance = np.zeros_like(albedo)
    integrator = mi.load_dict({"type": "path", "max_depth": int(bounces) + 2, "rr_depth": 8})
    for part in range(0, samples, AT_ONCE):
        count = min(AT_ONCE, samples - part)
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed * samples + part, count * width * height)
        found = integrator.sample(scene, sampler, rays_of(view, width, height, fov, count))[0]
        radiance += np.array(found).T.reshape(-1, count, 3).sum(axis=1) / samples
    # Of lamps, windows and the sky their own light: what a picture shows of them has full light.
    light = np.pi * radiance / np.where(counts[:, None], np.maximum(albedo, 1e-3), 1.0)
    light, normal, at = (
        np.asarray(each).reshape(height, width, 3) for each in (light, np.array(at.sh_frame.n).T, np.array(at.p).T)
    )
    counts = counts.reshape(height, width)
    return averaged(light, counts, normal, at), counts


def averaged(light, counts, normal, at):
    """Return light averaged over near pixels of the same surface that count, its own where none do."""
    total, weight = np.zeros_like(light), np.zeros(light.shape[:2])
    for dy in range(-MEAN_OVER, MEAN_OVER + 1):
        for dx in range(-MEAN_OVER, MEAN_OVER + 1):
            moved = [np.roll(each, (dy, dx), axis=(0, 1)) for each in (light, counts, normal, at)]
            flat = np.abs(((moved[3] - at) * normal).sum(axis=2)) < 0.01
            same = moved[1] & flat & ((moved[2] * normal).sum(axis=2) > 0.99)
            same[:, : max(dx, 0)] = same[: max(dy, 0)] = False
            if dy < 0:
                same[dy:] = False
            if dx < 0:
                same[:, dx:] = False
            total += np.where(same[..., None], moved[0], 0.0)
            weight += same
    return np.where(weight[..., None] > 0, total / np.maximum(weight, 1.0)[..., None], light)


if __name__ == "__main__":
    mi.set_variant("llvm_ad_rgb")
    given, samples = np.load(sys.argv[1]), int(sys.argv[3])
    traced, found = scene_of(given), []
    for number, view in enumerate(given["views"]):
        halves = [light_of(traced, view, given["size"], given["bounces"], samples // 2, 2 * number + k) for k in (0, 1)]
        found.append([np.dstack(half) for half in halves])
    np.save(sys.argv[2], np.array(found))
