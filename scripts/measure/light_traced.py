"""Compute the light at each pixel of views with Mitsuba; `light.py` starts it with an interpreter that has Mitsuba.

python light_traced.py SCENE.npz RESULT.npy SAMPLES

The result has, for each view, the light on the surface in each pixel, relative to full light, red, green and blue, and
1 where it counts, shape (views, height, width, 4). Noise is averaged over pixels of one surface.
"""

import sys

import mitsuba as mi
import numpy as np

GAMMA = 2.2
MEAN_OVER = 3
"""Half the side of the square over which noise is averaged [px]."""
STRAY = 0.4
"""Largest deviation of a pixel from the mean of its neighbours that counts as noise."""


def textured(points, places, reflectance, glow, name):
    """Return triangles with a diffuse surface."""
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": reflectance})
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


def rgb(values):
    """Return a colour of Mitsuba."""
    return {"type": "rgb", "value": [float(value) for value in values]}


def scene_of(file):
    """Return the scene."""
    parts = {"type": "scene"}
    for key in file.files:
        kind, number = key.rstrip("0123456789"), key.lstrip("abcdefghijklmnopqrstuvwxyz")
        if kind == "points":
            reflectance, places = rgb(file[f"albedo{number}"]), None
            if f"picture{number}" in file:
                picture = (file[f"picture{number}"] / 255.0) ** GAMMA
                share = file[f"albedo{number}"] / np.maximum(picture.reshape(-1, 3)[::17].mean(axis=0), 1e-6)
                bitmap = mi.Bitmap(np.ascontiguousarray(picture * share, dtype=np.float32))
                reflectance, places = {"type": "bitmap", "bitmap": bitmap, "raw": True}, file[f"places{number}"]
            parts[key] = textured(file[key], places, reflectance, file[f"glow{number}"], key)
        if kind == "lamp":
            middle, across, along, radiance = file[key]
            corners = np.array([middle - across - along, middle + across - along, middle + across + along])
            square = np.concatenate([corners, corners[[0, 2]], [middle - across + along]])
            parts[key] = textured(square, None, rgb([0, 0, 0]), radiance, key)
    sky = np.zeros((64, 128, 3), np.float32)
    sky[:32] = file["sky"]
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    parts["sky"] = {"type": "envmap", "bitmap": mi.Bitmap(sky), "to_world": upright}
    return mi.load_dict(parts)


def camera_of(view, width, height, fov):
    """Return a camera."""
    x, y, z, heading = view
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": float(fov),
            "fov_axis": "x",
            "near_clip": 0.01,
            "to_world": mi.ScalarTransform4f().look_at(origin=[x, y, z], target=[x + c, y + s, z], up=[0, 0, 1]),
            "film": {
                **{"type": "hdrfilm", "width": int(width), "height": int(height), "pixel_format": "rgb"},
                "rfilter": {"type": "box"},
            },
        }
    )


def light_of(scene, camera, bounces, samples):
    """Return the light in each pixel, and where it counts."""
    path = {"type": "path", "max_depth": int(bounces) + 2, "rr_depth": 8, "hide_emitters": False}
    aov = {"type": "aov", "aovs": "albedo:albedo,n:sh_normal,at:position", "img": path}
    image = np.array(mi.render(scene, sensor=camera, integrator=mi.load_dict(aov), spp=samples))
    radiance, albedo, normal, at = image[..., :3], image[..., -9:-6], image[..., -6:-3], image[..., -3:]
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    # A pixel of two surfaces has the light of neither.
    counts = (albedo.min(axis=2) > 1e-3) & (length[..., 0] > 0.995)
    normal = normal / np.maximum(length, 1e-6)
    light = np.where(counts[..., None], np.pi * radiance / np.maximum(albedo, 1e-3), 0.0)
    mean = averaged(light, counts, normal, at)
    # Rays between a picture and its wall, half a millimetre apart, find no light.
    counts &= (np.abs(light - mean) < STRAY * mean).all(axis=2)
    return filled(averaged(light, counts, normal, at), counts), counts


def filled(light, counts):
    """Return light with that of a neighbour where it does not count, for pixels on edges."""
    known, light = counts.copy(), light.copy()
    for dy, dx in [(0, 1), (0, -1), (1, 0), (-1, 0)] * 2:
        near, seen = np.roll(light, (dy, dx), axis=(0, 1)), np.roll(known, (dy, dx), axis=(0, 1))
        light[~known & seen], known = near[~known & seen], known | seen
    return light


def averaged(light, counts, normal, at):
    """Return light averaged over near pixels of the same surface, shape (height, width, 3)."""
    total, weight = np.zeros_like(light), np.zeros(light.shape[:2])
    for dy in range(-MEAN_OVER, MEAN_OVER + 1):
        for dx in range(-MEAN_OVER, MEAN_OVER + 1):
            moved = [np.roll(each, (dy, dx), axis=(0, 1)) for each in (light, counts, normal, at)]
            flat = np.abs(((moved[3] - at) * normal).sum(axis=2)) < 0.01
            same = counts & moved[1] & flat & ((moved[2] * normal).sum(axis=2) > 0.99)
            same[:, : max(dx, 0)] = same[: max(dy, 0)] = False
            if dy < 0:
                same[dy:] = False
            if dx < 0:
                same[:, dx:] = False
            total += np.where(same[..., None], moved[0], 0.0)
            weight += same
    return total / np.maximum(weight, 1.0)[..., None]


if __name__ == "__main__":
    mi.set_variant("llvm_ad_rgb")
    given = np.load(sys.argv[1])
    width, height, fov = given["size"]
    traced, found = scene_of(given), []
    for view in given["views"]:
        light, counts = light_of(traced, camera_of(view, width, height, fov), given["bounces"], int(sys.argv[3]))
        found.append(np.dstack([light, counts]))
    np.save(sys.argv[2], np.array(found))
