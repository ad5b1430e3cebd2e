"""The same scenes rendered by solidtrace and by Mitsuba 3, pixel by pixel.

    pip install mitsuba numpy
    python benches/peers/mitsuba_images.py target/release/solidtrace [SCENE ...]

Rough metal and rough glass differ by definition: ours mask by Smith's height-correlated term and metal gets back what it
loses to multiple scattering, Mitsuba masks both directions apart and loses it. Both show at grazing angles.

Each renderer renders each scene with RUNS seeds. Means over the picture must agree within 0.3 % in every channel, and of
Welch's t-tests, one for each pixel and channel, no more may fall below p = 0.01 than 1.3 %: with skewed noise the rate of
a true test is near 1 %, not at it.
"""

import pathlib
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
from mitsuba import ScalarTransform4f as T  # noqa: E402

SIZE = 128
RUNS = 16
SPP = 32
ASSETS = pathlib.Path(__file__).resolve().parents[2] / "assets"


# A scene is a list of (shape, material); both renderers' words for each stand side by side.


def diffuse(*color):
    return f"Diffuse(color: {color})", {
        "type": "diffuse",
        "reflectance": {"type": "rgb", "value": list(color)},
    }


def checker(a, b, tiles):
    """Squares over surface coordinates, `tiles` in a unit."""
    return (
        f"Diffuse(color: UvChecker(a: {a}, b: {b}, step: {1 / tiles}))",
        {
            "type": "diffuse",
            "reflectance": {
                "type": "checkerboard",
                "color0": {"type": "rgb", "value": list(a)},
                "color1": {"type": "rgb", "value": list(b)},
                "to_uv": T().scale([tiles / 2, tiles / 2, 1]),
            },
        },
    )


def lamp(*radiance):
    return f"Emissive(radiance: {radiance})", {
        "type": "area",
        "radiance": {"type": "rgb", "value": list(radiance)},
    }


GLASS = ("Dielectric(ior: 1.5)", {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0})


def rough_glass(alpha):
    return (
        f"Dielectric(ior: 1.5, roughness: {alpha**0.5})",
        {"type": "roughdielectric", "int_ior": 1.5, "ext_ior": 1.0, "alpha": alpha},
    )


GOLD = ([0.143, 0.375, 1.442], [3.983, 2.386, 1.603])


def metal(alpha):
    (eta, k), ours = GOLD, f"roughness: {alpha**0.5}"
    values = {
        "eta": {"type": "rgb", "value": eta},
        "k": {"type": "rgb", "value": k},
    }
    if alpha == 0:
        return f"Conductor(eta: {tuple(eta)}, k: {tuple(k)})", {"type": "conductor", **values}
    return (
        f"Conductor(eta: {tuple(eta)}, k: {tuple(k)}, {ours})",
        {"type": "roughconductor", "alpha": alpha, **values},
    )


def plastic(*color):
    return (
        f"Plastic(color: {color}, ior: 1.5)",
        {
            "type": "plastic",
            "diffuse_reflectance": {"type": "rgb", "value": list(color)},
            "int_ior": 1.5,
            "ext_ior": 1.0,
            "nonlinear": True,
        },
    )


def mirror(*color):
    return f"Mirror(color: {color})", {
        "type": "conductor",
        "material": "none",
        "specular_reflectance": {"type": "rgb", "value": list(color)},
    }


def sphere(center, radius):
    return (
        f"Sphere(center: {center}, radius: {radius}",
        {"type": "sphere", "center": list(center), "radius": radius},
    )


def box(center, size):
    half = [s / 2 for s in size]
    return (
        f"Box(center: {center}, size: {size}",
        {"type": "cube", "to_world": T().translate(list(center)).scale(half)},
    )


def mesh(name, scale, move):
    return (
        f'Mesh(file: "{ASSETS / name}", transform: [Scale({scale}), Translate({move})]',
        {
            "type": "obj",
            "filename": str(ASSETS / name),
            "flip_tex_coords": False,
            "to_world": T().translate(list(move)).scale(list(scale)),
        },
    )


WHITE = diffuse(0.75, 0.75, 0.75)


def room(*things, light=True):
    """Two metres wide, open in front; lit by a panel."""
    walls = [
        (box((0, -0.05, 0), (2.2, 0.1, 2)), WHITE),
        (box((0, 2.05, 0), (2.2, 0.1, 2)), WHITE),
        (box((0, 1, -1.05), (2.2, 2.2, 0.1)), WHITE),
        (box((-1.05, 1, 0), (0.1, 2.2, 2)), diffuse(0.63, 0.07, 0.05)),
        (box((1.05, 1, 0), (0.1, 2.2, 2)), diffuse(0.14, 0.45, 0.09)),
    ]
    panel = [(mesh("quad.obj", (0.6, 1, 0.6), (0, 1.999999, 0)), lamp(12, 11, 9))]
    return walls + (panel if light else []) + list(things)


def many_lights():
    rng = np.random.default_rng(1)
    lights = []
    for _ in range(60):
        center = tuple(float(x) for x in rng.uniform([-0.9, 0.9, -0.9], [0.9, 1.9, 0.6]))
        lights.append((sphere(center, 0.02), lamp(*(float(x) for x in rng.uniform(5, 60, 3)))))
    return lights


BLOCK = (box((-0.4, 0.35, -0.4), (0.5, 0.7, 0.5)), WHITE)
BALL = sphere((0.4, 0.35, 0.2), 0.35)

SCENES = {
    "diffuse box": (room(BLOCK, (BALL, WHITE)), None),
    "glass": (room(BLOCK, (BALL, GLASS)), None),
    "rough glass": (room(BLOCK, (BALL, rough_glass(0.04))), None),
    "mirror": (room(BLOCK, (BALL, mirror(0.9, 0.8, 0.7))), None),
    "rough metal": (room(BLOCK, (BALL, metal(0.1))), None),
    "plastic": (room(BLOCK, (BALL, plastic(0.2, 0.3, 0.7))), None),
    "environment": (
        [
            (box((0, -0.05, 0), (3, 0.1, 3)), diffuse(0.6, 0.5, 0.4)),
            BLOCK,
            (BALL, metal(0.0)),
        ],
        (0.7, 0.9, 1.2),
    ),
    "many lights": (room(BLOCK, (BALL, WHITE), *many_lights(), light=False), None),
    "textured mesh": (
        room((mesh("quad.obj", (1.6, -1, 1.6), (0, 0.01, 0)), checker((0.8, 0.7, 0.6), (0.1, 0.2, 0.3), 8)),
             BLOCK),
        None,
    ),
    "girl": (room((mesh("girl.obj", (1.1, 1.1, 1.1), (0, 0, 0)), diffuse(0.6, 0.5, 0.45))), None),
}

EYE, TARGET, FOV, DEPTH = (0, 1, 3.6), (0, 1, 0), 40, 6


def ron(objects, environment):
    materials, lines = {}, []
    for (shape, _), (material, _) in objects:
        name = materials.setdefault(material, f"m{len(materials)}")
        lines.append(f'{shape}, material: "{name}"),')
    table = "\n".join(f'"{name}": {text},' for text, name in materials.items())
    light = f"environment: Constant(color: {environment})," if environment else ""
    return f"""Scene(
        film: (size: ({SIZE}, {SIZE}), spp: {SPP}, filter: Box(radius: 0.5)),
        camera: Perspective(eye: {EYE}, look_at: {TARGET}, vfov: {FOV}),
        integrator: Path(max_depth: {DEPTH}),
        {light}
        materials: {{ {table} }},
        objects: [ {chr(10).join(lines)} ],
    )"""


def mitsuba_scene(objects, environment):
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH + 1, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": FOV,
            "fov_axis": "y",
            "to_world": T().look_at(origin=list(EYE), target=list(TARGET), up=[0, 1, 0]),
            "film": {
                "type": "hdrfilm",
                "width": SIZE,
                "height": SIZE,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        },
    }
    if environment:
        scene["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": list(environment)}}
    for i, ((_, shape), (_, material)) in enumerate(objects):
        key = "emitter" if material["type"] == "area" else "bsdf"
        if material["type"] == "diffuse":
            material = {"type": "twosided", "inner": material}
        scene[f"s{i}"] = {**shape, key: material}
    return mi.load_dict(scene)


def ours(program, objects, environment):
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.ron"
        scene.write_text(ron(objects, environment))
        for seed in range(RUNS):
            out = pathlib.Path(folder) / f"{seed}.exr"
            command = [program, "render", scene, "-o", out, "--seed", str(seed), "--allow-path", ASSETS]
            subprocess.run(command, check=True, capture_output=True)
            yield np.array(mi.Bitmap(str(out)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32))


def theirs(objects, environment):
    scene = mitsuba_scene(objects, environment)
    for seed in range(RUNS):
        yield np.array(mi.render(scene, spp=SPP, seed=seed))


def compare(name, a, b):
    a, b = (np.stack(list(runs)).astype(np.float64) for runs in (a, b))
    means = a.mean(axis=(0, 1, 2)) / b.mean(axis=(0, 1, 2)) - 1
    va, vb = (runs.var(axis=0, ddof=1) / RUNS for runs in (a, b))
    apart = np.abs(a.mean(axis=0) - b.mean(axis=0))
    certain = va + vb == 0
    t = apart / np.sqrt(np.where(certain, 1, va + vb))
    # Two-sided p = 0.01 of Student's t with 2 (RUNS - 1) degrees of freedom, 30.
    low = np.where(certain, apart > 1e-5, t > 2.75).mean()
    good = np.abs(means).max() < 0.003 and low < 0.013
    worst = " ".join(f"{100 * m:+.3f} %" for m in means)
    noise = vb.mean() / va.mean()
    print(f"{name:>14}  means {worst}  low p {100 * low:.2f} %  variance {noise:.2f}x  {'agree' if good else 'DIFFER'}", flush=True)
    return good, a.mean(axis=0), b.mean(axis=0)


def main():
    program, names = sys.argv[1], sys.argv[2:] or list(SCENES)
    good = True
    for name in names:
        scene = SCENES[name]
        fine, a, b = compare(name, ours(program, *scene), theirs(*scene))
        good &= fine
        if not fine:
            stem = name.replace(" ", "_")
            both = np.concatenate([a, b, np.abs(a - b) * 10], axis=1).astype(np.float32)
            mi.util.write_bitmap(f"{stem}.png", both)
    sys.exit(not good)


if __name__ == "__main__":
    main()
