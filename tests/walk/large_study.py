"""Writes a study of large meshes: `large_study.py FOLDER GEOMETRIES MILLIONS`, a PLY of so many million triangles for each
geometry, the scene that stands them in the proof room, and study.json, whose pictures are small."""

import array
import json
import math
import pathlib
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[2]
MATERIALS = ["MS", "GS"]
ILLUMINATIONS = ["ind", "dir"]
COUNTS = ["1k", "30k"]


def write_mesh(path, waves, triangles):
    """A bumpy sphere, open at its poles."""
    rows = max(2, round(math.sqrt(triangles / 4)))
    columns = 2 * rows
    positions, faces = array.array("f"), bytearray()
    for i in range(rows + 1):
        theta = math.pi * (i + 0.5) / (rows + 1)
        for j in range(columns):
            phi = 2 * math.pi * j / columns
            r = 1 + 0.1 * math.sin(theta) * math.sin(3 * theta) * math.sin(waves * phi)
            positions.extend((r * math.sin(theta) * math.cos(phi), r * math.sin(theta) * math.sin(phi), r * math.cos(theta)))
    for i in range(rows):
        for j in range(columns):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            for corners in ((a, a + columns, b), (b, a + columns, b + columns)):
                faces += b"\3" + array.array("I", corners).tobytes()
    with open(path, "wb") as file:
        file.write(
            "ply\nformat binary_little_endian 1.0\n"
            f"element vertex {len(positions) // 3}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {2 * rows * columns}\nproperty list uchar int vertex_indices\nend_header\n".encode()
        )
        file.write(positions.tobytes() + faces)


def write_json(path, value):
    path.write_text(json.dumps(value, indent=1) + "\n")


def make_scene(geometries):
    scene = json.loads((SOURCE / "stimuli/scenes/proof-room.json").read_text())
    room = [mesh for mesh in scene["meshes"] if "quad" in mesh]
    scene["meshes"] = room + [{"name": g, "file": {"path": f"{g}.ply", "radius": 0.45}} for g in geometries]
    scene["object"]["geometries"] = [{"name": g, "mesh": g} for g in geometries]
    return scene


def make_study(geometries):
    study = json.loads((SOURCE / "protocols/pocket.json").read_text())
    del study["reference"]  # of fixed paths
    study |= {"name": "large", "scene": "scene.json", "image": {"width": 48, "height": 36}, "subpixel_positions": 1}
    study |= {name: f"{name}.json" for name in ("windows", "truth", "session")}
    study["paths"] = {"object_indirect": 32, "object_direct": 32, "background": 32}
    block = {"geometries": geometries, "materials": MATERIALS, "illuminations": ILLUMINATIONS, "vpl_counts": COUNTS}
    return study | {"blocks": [block]}


def main(folder, count, millions):
    folder.mkdir(parents=True, exist_ok=True)
    geometries = [f"G{i}" for i in range(count)]
    for i, geometry in enumerate(geometries):
        write_mesh(folder / f"{geometry}.ply", 3 + i, millions * 1e6)
    columns = [f"{g}-{m}-{i}-{c}" for g in geometries for m in MATERIALS for i in ILLUMINATIONS for c in COUNTS]
    windows = [{"column": column, "first": "C2", "origin": "placeholder"} for column in columns]
    truth = [{"column": column, "artifact_free_from": "C4", "material_same_to": "C6"} for column in columns]
    write_json(folder / "scene.json", make_scene(geometries))
    write_json(folder / "study.json", make_study(geometries))
    write_json(folder / "session.json", {"schema": "equilux-session", "schema_version": 1})
    write_json(folder / "windows.json", {"schema": "equilux-windows", "schema_version": 1, "windows": windows})
    rates = {"lapse_rate": 0.02, "side_bias": 0.5}
    write_json(folder / "truth.json", {"schema": "equilux-truth", "schema_version": 1, **rates, "columns": truth})


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
