"""How soon solidtrace, Mitsuba 3 and Cycles come to the same noise: a diffuse room with a scan-like mesh.

    pip install mitsuba numpy        # Mitsuba's LLVM backend also needs an LLVM that knows the processor
    pip install bpy                  # Cycles; may live in another environment, given by --cycles
    python benches/peers/efficiency.py target/release/solidtrace [--cycles PYTHON] [--rounds 3] [--only NAME]

All render 512x512 pixels, 64 samples each, paths of six bounces, two threads, box filter, no clamping and no denoising;
Mitsuba with each of two samplers. A round renders with two seeds, from which the variance is, and a quarter of the samples:
the difference in time is that of samples alone, without loading and building. Efficiency is 1 / (variance x time).
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

SIZE, SPP, DEPTH, THREADS = 512, 64, 6, 2
EYE, TARGET, FOV = (0, 1, 3.6), (0, 1, 0), 40
RADIANCE = (12, 11, 9)

# Boxes as (center, size, colour), and the panel under the ceiling as (center, size).
BOXES = [
    ((0, -0.05, 0), (2.2, 0.1, 2), (0.75, 0.75, 0.75)),
    ((0, 2.05, 0), (2.2, 0.1, 2), (0.75, 0.75, 0.75)),
    ((0, 1, -1.05), (2.2, 2.2, 0.1), (0.75, 0.75, 0.75)),
    ((-1.05, 1, 0), (0.1, 2.2, 2), (0.63, 0.07, 0.05)),
    ((1.05, 1, 0), (0.1, 2.2, 2), (0.14, 0.45, 0.09)),
]
PANEL = ((0, 1.9999, 0), (0.6, 0.6))
MESH_COLOR = (0.6, 0.5, 0.45)


def scan(path, rows=188):
    """A lumpy sphere of 2 rows (rows - 1) triangles, here 70,312, standing on the floor; as OBJ."""
    theta = np.linspace(0, np.pi, rows + 1)[1:-1, None]
    phi = np.linspace(0, 2 * np.pi, rows, endpoint=False)[None]
    ring = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta) + 0 * phi, np.sin(theta) * np.sin(phi)], -1)
    points = np.concatenate([[[0, 1, 0]], ring.reshape(-1, 3), [[0, -1, 0]]])
    lumps = sum(np.sin(points @ wave) / np.linalg.norm(wave) for wave in np.random.default_rng(7).normal(0, 12, (24, 3)))
    points = points * (0.6 + 0.35 * lumps[:, None])
    points = points - [0, points[:, 1].min(), 0]
    at = lambda i, j: 1 + i * rows + j % rows  # noqa: E731
    faces = [(0, at(0, j + 1), at(0, j)) for j in range(rows)]
    for i in range(rows - 2):
        for j in range(rows):
            a, b, c, d = at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)
            faces += [(a, b, c), (b, d, c)]
    faces += [(at(rows - 2, j), at(rows - 2, j + 1), len(points) - 1) for j in range(rows)]
    with open(path, "w") as out:
        out.writelines(f"v {x:.7g} {y:.7g} {z:.7g}\n" for x, y, z in points)
        out.writelines(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)


class Ours:
    def __init__(self, program, folder, mesh):
        self.program, self.folder = program, folder
        colors = sorted({color for *_, color in BOXES} | {MESH_COLOR})
        table = "".join(f'"m{i}": Diffuse(color: {c}), ' for i, c in enumerate(colors))
        name = lambda color: f'"m{colors.index(color)}"'  # noqa: E731
        boxes = "".join(f"Box(center: {c}, size: {s}, material: {name(m)}), " for c, s, m in BOXES)
        (x, y, z), (w, d) = PANEL
        (folder / "panel.obj").write_text(
            "".join(f"v {x + sx * w / 2} {y} {z + sz * d / 2}\n" for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1))) + "f 1 2 3 4\n"
        )
        (folder / "scene.ron").write_text(
            f"""Scene(
            film: (size: ({SIZE}, {SIZE}), spp: {SPP}, filter: Box(radius: 0.5)),
            camera: Perspective(eye: {EYE}, look_at: {TARGET}, vfov: {FOV}),
            integrator: Path(max_depth: {DEPTH}),
            materials: {{ {table} "lamp": Emissive(radiance: {RADIANCE}) }},
            objects: [ {boxes}
                Mesh(file: "{mesh.name}", smooth: false, material: {name(MESH_COLOR)}),
                Mesh(file: "panel.obj", material: "lamp"),
            ])"""
        )

    def render(self, spp, seed):
        out = self.folder / "ours.exr"
        command = [self.program, "render", self.folder / "scene.ron", "-o", out, "--force", "--quiet"]
        command += ["--spp", str(spp), "--seed", str(seed), "--threads", str(THREADS)]
        subprocess.run(command, check=True, capture_output=True)
        return read(out)


def read(path):
    import mitsuba as mi

    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
    return np.array(bitmap).astype(np.float64)


class Mitsuba:
    def __init__(self, variant, sampler, mesh):
        import mitsuba as mi

        mi.set_variant(variant)
        T = mi.ScalarTransform4f
        rgb = lambda c: {"type": "rgb", "value": list(c)}  # noqa: E731
        matt = lambda c: {"type": "twosided", "inner": {"type": "diffuse", "reflectance": rgb(c)}}  # noqa: E731
        scene = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": DEPTH + 1},
            "sensor": {
                "type": "perspective",
                "fov": FOV,
                "fov_axis": "y",
                "to_world": T().look_at(origin=list(EYE), target=list(TARGET), up=[0, 1, 0]),
                "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
                "sampler": {"type": sampler},
            },
            "mesh": {"type": "obj", "filename": str(mesh), "face_normals": True, "bsdf": matt(MESH_COLOR)},
        }
        for i, (center, size, color) in enumerate(BOXES):
            place = T().translate(list(center)).scale([s / 2 for s in size])
            scene[f"box{i}"] = {"type": "cube", "to_world": place, "bsdf": matt(color)}
        center, (w, d) = PANEL
        place = T().translate(list(center)).rotate([1, 0, 0], 90).scale([w / 2, d / 2, 1])
        scene["panel"] = {"type": "rectangle", "to_world": place, "light": {"type": "area", "radiance": rgb(RADIANCE)}}
        self.mi, self.variant, self.scene = mi, variant, mi.load_dict(scene)

    def render(self, spp, seed):
        self.mi.set_variant(self.variant)
        return np.array(self.mi.render(self.scene, spp=spp, seed=seed)).astype(np.float64)


# Runs under the Python that has bpy: reads "spp seed file" lines, answers each with the seconds it took.
CYCLES = """
import json, math, sys, time
import bpy
from mathutils import Vector
p = json.loads(sys.argv[1])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.world = bpy.data.worlds.new("black")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
turn = lambda v: (v[0], -v[2], v[1])
def material(kind, name, color, strength=None):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    nodes = m.node_tree.nodes
    nodes.clear()
    shader, out = nodes.new(kind), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*color, 1)
    if strength is not None:
        shader.inputs["Strength"].default_value = strength
    m.node_tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return m
def add(name, points, faces, m):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([turn(v) for v in points], [], faces)
    mesh.materials.append(m)
    scene.collection.objects.link(bpy.data.objects.new(name, mesh))
for i, (c, s, color) in enumerate(p["boxes"]):
    corners = [[c[k] + (1 if j >> k & 1 else -1) * s[k] / 2 for k in range(3)] for j in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    add(f"box{i}", corners, quads, material("ShaderNodeBsdfDiffuse", f"m{i}", color))
(x, y, z), (w, d) = p["panel"]
corners = [(x + a * w / 2, y, z + b * d / 2) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
strength = max(p["radiance"])
lamp = material("ShaderNodeEmission", "lamp", [v / strength for v in p["radiance"]], strength)
add("panel", corners, [(0, 1, 2, 3)], lamp)
points, faces = [], []
for line in open(p["mesh"]):
    kind, *words = line.split()
    if kind == "v":
        points.append([float(v) for v in words])
    else:
        faces.append([int(v) - 1 for v in words])
add("mesh", points, faces, material("ShaderNodeBsdfDiffuse", "mesh", p["mesh_color"]))
camera = bpy.data.cameras.new("camera")
camera.sensor_fit = "VERTICAL"
camera.angle = math.radians(p["fov"])
eye = bpy.data.objects.new("camera", camera)
eye.location = turn(p["eye"])
eye.rotation_euler = (Vector(turn(p["target"])) - Vector(turn(p["eye"]))).to_track_quat("-Z", "Y").to_euler()
scene.collection.objects.link(eye)
scene.camera = eye
r, c = scene.render, scene.cycles
r.resolution_x = r.resolution_y = p["size"]
r.resolution_percentage = 100
r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
r.threads_mode, r.threads = "FIXED", p["threads"]
r.use_persistent_data = True
c.device, c.use_adaptive_sampling, c.use_denoising = "CPU", False, False
c.sample_clamp_direct = c.sample_clamp_indirect = 0
c.pixel_filter_type = "BOX"
c.blur_glossy = 0
c.max_bounces = c.diffuse_bounces = p["depth"]
print("ready", flush=True)
for line in sys.stdin:
    spp, seed, path = line.split()
    c.samples, c.seed, r.filepath = int(spp), int(seed), path
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    print(f"took {time.perf_counter() - start}", flush=True)
"""


class Cycles:
    def __init__(self, python, folder, mesh):
        self.out = folder / "cycles.exr"
        scene = dict(boxes=BOXES, panel=PANEL, radiance=RADIANCE, mesh=str(mesh), mesh_color=MESH_COLOR, eye=EYE, target=TARGET)
        scene |= dict(fov=FOV, size=SIZE, depth=DEPTH, threads=THREADS)
        self.worker = subprocess.Popen(
            [python, "-c", CYCLES, json.dumps(scene)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        self.wait("ready")

    def wait(self, word):
        for line in self.worker.stdout:
            if line.startswith(word):
                return
        sys.exit("Cycles ended before it answered")

    def render(self, spp, seed):
        print(spp, seed, self.out, file=self.worker.stdin, flush=True)
        self.wait("took")
        return read(self.out)


def measure(renderer, seed):
    """Mean colour, variance a pixel and channel, and seconds for SPP samples."""
    times, images = [], []
    for spp, s in ((SPP, seed), (SPP // 4, seed), (SPP, seed + 1)):
        start = time.perf_counter()
        images.append(renderer.render(spp, s))
        times.append(time.perf_counter() - start)
    first, _, second = images
    seconds = ((times[0] + times[2]) / 2 - times[1]) * 4 / 3
    return (first + second).mean((0, 1)) / 2, ((first - second) ** 2).mean() / 2, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--cycles", default=sys.executable, metavar="PYTHON")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="", help="renderers whose name contains this, beside ours")
    args = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", str(THREADS))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        mesh = folder / "scan.obj"
        scan(mesh)
        import mitsuba as mi

        mi.set_variant("scalar_rgb")
        makers = {"solidtrace": lambda: Ours(args.program, folder, mesh)}
        for variant in ("scalar_rgb", "llvm_ad_rgb"):
            for sampler in ("independent", "multijitter"):
                makers[f"{variant} {sampler}"] = lambda v=variant, s=sampler: Mitsuba(v, s, mesh)
        makers["cycles"] = lambda: Cycles(args.cycles, folder, mesh)
        field = {name: make() for name, make in makers.items() if name == "solidtrace" or args.only in name}
        for renderer in field.values():
            renderer.render(1, 0)
        runs = {name: [] for name in field}
        for r in range(args.rounds):
            for name, renderer in field.items():
                runs[name].append(measure(renderer, 2 * r + 1))
                mean, variance, seconds = runs[name][-1]
                print(f"round {r + 1}  {name:<24} mean {mean.round(5)}  variance {variance:.3e}  {seconds:.2f} s", flush=True)
    print(f"\n{'ours to':<24} {'efficiency':>22} {'time':>14} {'variance':>10} {'mean':>9}")
    for name, theirs in runs.items():
        pairs = list(zip(runs["solidtrace"], theirs))
        efficiency = [tv * tt / (ov * ot) for (_, ov, ot), (_, tv, tt) in pairs]
        slower = statistics.median(ot / tt for (_, _, ot), (_, _, tt) in pairs)
        noise = statistics.median(tv / ov for (_, ov, _), (_, tv, _) in pairs)
        apart = max(abs(o / t - 1).max() for (o, *_), (t, *_) in pairs)
        spread = f"{statistics.median(efficiency):.2f} ({min(efficiency):.2f}-{max(efficiency):.2f})"
        print(f"{name:<24} {spread:>22} {slower:>13.2f}x {noise:>9.2f}x {100 * apart:>7.2f} %")


if __name__ == "__main__":
    main()
