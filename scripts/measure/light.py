#!/usr/bin/env python3
"""Compare baked light with a path tracer: pictures of four worlds, four views each, plain, high, baked, path traced.

.venv/bin/python scripts/measure/light.py [WORLD ...] [--tracer PYTHON] [--samples 256] [--views 4] [-o FOLDER]

PYTHON is an interpreter with Mitsuba (`pip install mitsuba`; beside Mesa's LLVM 15 it needs Debian's libllvm19). It
computes the light at each pixel; colours come from MuJoCo in all pictures. PSNR and SSIM are of pixels that show
static surfaces, 10 px and more from lamps and windows. References are computed once and kept.
"""

import argparse
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import mujoco
import numpy as np

from mjsim.compile import compile_world, compiled, texture_of
from mjsim.light import DOOR, GENERAL, BakedLight, bake, coded
from mjsim.light.bake import sources_of
from mjsim.light.emitters import SKY_RADIANCE, window_rectangles
from mjsim.light.light_geometry import atlas_of
from mjsim.light.stored import key_of, store, stored
from mjsim.output import user_cache
from mjsim.sim import Canvas, Renderer
from mjsim.world import load_checked

VIEWS = {
    "gallery": [(2.7, 1.9, 1.0, 0), (11.3, 2.4, 1.0, 90), (11.3, 8.4, 1.0, 200), (2.7, 8.1, 1.0, -60)],
    "office": [(3, 6.2, 0.9, 0), (1.9, 4, 0.9, -90), (9, 8.6, 0.9, 60), (30, 6.4, 0.9, 170)],
    "dark": [(1.6, 2, 1, 30), (10.4, 6.2, 1, 200), (6, 1.5, 1, 180), (3.5, 6.8, 1, -50)],
    "corridor": [(1.2, 1.2, 1, 0), (28, 1.2, 1, 170), (22, 1.6, 1, 0), (15, 1.2, 1, 190)],
}
"""Views of each world: x, y, z [m] and heading [deg]."""
AROUND_LAMPS = 10
"""Pixels around lamps and windows that are left out."""
TRACED_BOUNCES = 16
"""Reflections that the path tracer follows."""
WIDTH, HEIGHT, FOV = 320, 240, 60.0


def scene_of(name: str) -> tuple:
    """Return a world with the cameras of its views, its model, and a state."""
    world = load_checked(name).model_copy(update={"shading": "baked"})
    spec = compile_world(world)
    fovy = np.degrees(2 * np.arctan(np.tan(np.radians(FOV / 2)) * HEIGHT / WIDTH))
    for index, (x, y, z, heading) in enumerate(VIEWS[name]):
        c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
        spec.worldbody.add_camera(name=f"view{index}", pos=[x, y, z], xyaxes=[s, -c, 0, 0, 0, 1], fovy=fovy)
    model = compiled(spec)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return world, model, data


def light_and_cost(world, model) -> BakedLight:
    """Return the light of a world, and print what it costs."""
    began, before = time.perf_counter(), processor_time()
    light = bake(world, model)
    seconds, busy = time.perf_counter() - began, processor_time() - before
    key = key_of(world, model)
    store(key, light)
    began = time.process_time()
    stored(key_of(world, model))
    size = (user_cache("light") / key).stat().st_size / 1e6
    print(
        f"{world.name}: baked in {seconds:.1f} s, {busy:.1f} s of processor time; {len(light.groups)} maps of "
        f"{light.groups[0].texels.shape[1]} x {light.groups[0].texels.shape[0]}, {size:.1f} MB in the cache; "
        f"from the cache in {time.process_time() - began:.2f} s of processor time"
    )
    return light


def processor_time() -> float:
    """Return processor time of this process and its children [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def drawn(model, data, count: int, *, light: BakedLight | None = None, quality: str = "normal") -> list:
    """Return the pictures of all views."""
    canvas = Canvas(model, quality=quality, light=None if light is None else lambda: light)
    renderer = Renderer(model, width=WIDTH, height=HEIGHT, canvas=canvas)
    try:
        return [renderer.render(data, f"view{index}").copy() for index in range(count)]
    finally:
        renderer.close()
        canvas.close()


def even(light: BakedLight) -> BakedLight:
    """Return full light everywhere: pictures in it show colours alone."""
    ones = np.ones_like(light.groups[0].texels)
    group = replace(light.groups[0], texels=ones, start=np.ones(3), name="")
    probes = replace(light.probes, light=np.ones_like(light.probes.light[:1]))
    return replace(light, groups=(group,), probes=probes, exposure=1.0)


def exported(world, model, light: BakedLight, views: list, place: Path) -> None:
    """Write all that a path tracer needs."""
    atlas = atlas_of(world, model)
    opened = {group.name for group in light.groups if group.name.startswith(DOOR) and group.start.max() > 0.5}
    hidden = {solid for name, states in atlas.ajar.items() for solid in states[name not in opened]}
    windows = window_rectangles(world, atlas.room()[0])
    sources = sources_of(world, windows)
    gain = next(group.gain for group in light.groups if group.name == GENERAL)
    general = sources.start[sources.names.index(GENERAL)]
    arrays = {"views": np.array(views, float), "sky": SKY_RADIANCE * gain * general, "bounces": TRACED_BOUNCES}
    arrays["size"] = np.array([WIDTH, HEIGHT, FOV])
    weights = [gain if name == GENERAL else 1.0 for name in sources.names]
    colors = sources.colors.reshape(-1, len(sources.names), 3)
    power = np.einsum("rgc,gc,g->rc", colors, sources.start, np.array(weights))
    for index, (rectangle, color) in enumerate(zip(sources.rectangles, power, strict=True)):
        corners = [rectangle.middle, rectangle.across, rectangle.along, color * rectangle.radiance]
        arrays[f"lamp{index}"] = np.array(corners)
    for index, solid in enumerate(atlas.solids):
        if index in hidden:
            continue
        own = solid.glow + float(world.ceiling is not None and solid.is_ceiling)
        arrays[f"points{index}"] = solid.points[solid.triangles].reshape(-1, 3)
        arrays[f"albedo{index}"] = solid.albedo
        arrays[f"glow{index}"] = solid.albedo / np.pi * own * gain * general
        texture = texture_of(model, solid.geom)
        if texture >= 0 and solid.texcoords is not None:
            first, shape = model.tex_adr[texture], (model.tex_height[texture], model.tex_width[texture], -1)
            pixels = model.tex_data[first : first + shape[0] * shape[1] * model.tex_nchannel[texture]].reshape(shape)
            arrays[f"picture{texture}"], arrays[f"texture{index}"] = pixels[..., :3], texture
            arrays[f"places{index}"] = solid.texcoords[solid.triangles].reshape(-1, 2)
    np.savez(place, **arrays)


def compared(picture, truth, mask) -> tuple[float, float]:
    """Return PSNR [dB] and SSIM of the pixels of a mask."""
    picture = np.where(mask[..., None], picture, truth)  # What is left out does not count beside what is not.
    error = (picture.astype(float) - truth)[mask]
    psnr = 10 * np.log10(255**2 / max(float((error**2).mean()), 1e-9))
    a, b = (cv2.cvtColor(each, cv2.COLOR_RGB2GRAY).astype(float) for each in (picture, truth))
    blur = [cv2.GaussianBlur(each, (11, 11), 1.5) for each in (a, b, a * a, b * b, a * b)]
    (ma, mb), (va, vb, cov) = blur[:2], (blur[2] - blur[0] ** 2, blur[3] - blur[1] ** 2, blur[4] - blur[0] * blur[1])
    ssim = (2 * ma * mb + 6.5025) * (2 * cov + 58.5225) / ((ma**2 + mb**2 + 6.5025) * (va + vb + 58.5225))
    return psnr, float(ssim[mask].mean())


def _surfaces(model, data, index: int) -> np.ndarray:
    """Return the pixels of a view that show static surfaces."""
    renderer = Renderer(model, width=WIDTH, height=HEIGHT)
    try:
        geoms = renderer.segment(data, f"view{index}")
    finally:
        renderer.close()
    still = np.append(model.body_weldid[model.geom_bodyid] == 0, False)
    return still[geoms]


def _around_lamps(blank: np.ndarray) -> np.ndarray:
    """Return the pixels near lamps and windows, where the path tracer sees no surface."""
    whole = cv2.morphologyEx(blank.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3)))
    return cv2.dilate(whole, np.ones((2 * AROUND_LAMPS + 1,) * 2)) > 0


def measure(name: str, tracer: str, *, samples: int, count: int, folder: Path) -> None:
    """Print the figures of a world, and write its pictures."""
    world, model, data = scene_of(name)
    views, light = VIEWS[name][:count], light_and_cost(world, model)
    scene, traced = folder / f"{name}.npz", folder / f"{name}_{samples}.npy"
    exported(world, model, light, views, scene)
    if not traced.exists():
        tracing = Path(__file__).with_name("light_traced.py")
        subprocess.run([tracer, str(tracing), str(scene), str(traced), str(samples)], check=True)
    halves = np.load(traced)
    found = halves.mean(axis=1)
    colors = drawn(model, data, len(views), light=even(light))
    shown = {
        "plain": drawn(model, data, len(views)),
        "high": drawn(model, data, len(views), quality="high"),
        "baked": drawn(model, data, len(views), light=light),
    }
    factor = coded(np.asarray(found[..., :3] * light.exposure, np.float32)) / 255.0
    shown["traced"] = [np.rint(color * each).astype(np.uint8) for color, each in zip(colors, factor, strict=True)]
    parts = coded(np.asarray(halves[..., :3] * light.exposure, np.float32)) / 255.0
    twice = [
        [np.rint(color * half).astype(np.uint8) for half in each] for color, each in zip(colors, parts, strict=True)
    ]
    masks = [_surfaces(model, data, index) for index in range(len(views))]
    known = found[..., 3] > 0.5
    masks = [mask & each & ~_around_lamps(mask & ~each) for mask, each in zip(masks, known, strict=True)]
    for kind in ("plain", "high", "baked"):
        rows = [compared(*each) for each in zip(shown[kind], shown["traced"], masks, strict=True)]
        psnr, ssim = np.mean(rows, axis=0)
        print(
            f"{name} {kind}: PSNR {psnr:.1f} dB ({', '.join(f'{row[0]:.1f}' for row in rows)}), 1 - SSIM {1 - ssim:.4f}"
        )
    # The mean of both halves has a quarter of the squared difference of one from the other.
    noise = np.mean([compared(*pair, mask)[0] for pair, mask in zip(twice, masks, strict=True)]) + 10 * np.log10(4)
    print(f"{name} traced: noise {noise:.1f} dB")
    rows = [np.hstack([shown[kind][index] for kind in shown]) for index in range(len(views))]
    cv2.imwrite(str(folder / f"{name}.png"), np.vstack(rows)[..., ::-1])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", default=list(VIEWS))
    parser.add_argument("--tracer", default=sys.executable)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--views", type=int, default=4)
    parser.add_argument("-o", "--folder", type=Path, default=Path("light"))
    given = parser.parse_args()
    given.folder.mkdir(exist_ok=True)
    for each in given.worlds:
        measure(each, given.tracer, samples=given.samples, count=given.views, folder=given.folder)
