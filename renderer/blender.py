import argparse
import math
import os
import sys
import time

import bpy
from mathutils import Matrix, Vector


def numbers(text, kind, columns):
    values = [kind(word) for word in text.split()]
    return [tuple(values[i:i + columns]) for i in range(0, len(values), columns)]


# The same radiance from every direction.
def start(environment):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    world = bpy.data.worlds.new("environment")
    world.color = environment
    bpy.context.scene.world = world


def node_material(name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree


def material(name, rho_d):
    made, tree = node_material(name)
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*rho_d, 1)
    diffuse.inputs["Roughness"].default_value = 0
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return made


def mesh(name, positions, triangles, normals=""):
    made = bpy.data.meshes.new(name)
    made.from_pydata(numbers(positions, float, 3), [], numbers(triangles, int, 3))
    made.materials.append(None)
    if normals:
        made.polygons.foreach_set("use_smooth", [True] * len(made.polygons))
        made.use_auto_smooth = True
        made.auto_smooth_angle = math.pi
        made.normals_split_custom_set_from_vertices(numbers(normals, float, 3))
    return made


def add(data, name, matrix=None):
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    if matrix:
        made.matrix_world = matrix
    return made


# Cycles' two remedies for the shadow terminator bend light: the rule here is that light must come from the
# front of both normals, and its cosine is that of the interpolated one.
def add_surface(data, surface, matrix=None):
    made = add(data, data.name, matrix)
    made.material_slots[0].link = "OBJECT"
    made.material_slots[0].material = surface
    made.cycles.shadow_terminator_offset = 0
    made.cycles.shadow_terminator_geometry_offset = 0


# Turned about +x by tilt, then about +z by turn, scaled, moved. Angles in degrees.
def place(data, surface, at, turn=0, tilt=0, scale=1):
    turned = Matrix.Rotation(math.radians(turn), 4, "Z") @ Matrix.Rotation(math.radians(tilt), 4, "X")
    add_surface(data, surface, Matrix.Translation(at) @ turned @ Matrix.Scale(scale, 4))


# Radiant intensity in W/sr, with a smooth Hermite fall between the cosines. Cycles' own spot falls otherwise:
# this is a point light of radiant power 4 pi W, which is 1 W/sr, times a factor for the direction that it is
# seen from.
def spot(position, axis, cos_inner, cos_outer, intensity):
    light = bpy.data.lights.new("spot", "POINT")
    light.shadow_soft_size = 0
    light.energy = 4 * math.pi
    light.use_nodes = True
    tree = light.node_tree
    tree.nodes.clear()
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    cosine = tree.nodes.new("ShaderNodeVectorMath")
    cosine.operation = "DOT_PRODUCT"
    cosine.inputs[1].default_value = axis
    fall = tree.nodes.new("ShaderNodeMapRange")
    fall.interpolation_type = "SMOOTHSTEP"
    fall.inputs["From Min"].default_value = cos_outer
    fall.inputs["From Max"].default_value = cos_inner
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*intensity, 1)
    output = tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(geometry.outputs["Incoming"], cosine.inputs[0])
    tree.links.new(cosine.outputs["Value"], fall.inputs["Value"])
    tree.links.new(fall.outputs["Result"], emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    add(light, "spot", Matrix.Translation(position))


# A black parallelogram that shines to the side of u x v.
def rectangle(corner, u, v, radiance):
    surface, tree = node_material("emitter")
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    front = tree.nodes.new("ShaderNodeMath")
    front.operation = "SUBTRACT"
    front.inputs[0].default_value = 1
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*radiance, 1)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(geometry.outputs["Backfacing"], front.inputs[1])
    tree.links.new(front.outputs[0], emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    a, b, c = Vector(corner), Vector(u), Vector(v)
    made = bpy.data.meshes.new("emitter")
    made.from_pydata([a, a + b, a + b + c, a + c], [], [(0, 1, 2), (0, 2, 3)])
    made.materials.append(None)
    add_surface(made, surface)


def camera(position, target, up, vertical_fov, width, height):
    forward = (Vector(target) - Vector(position)).normalized()
    right = forward.cross(Vector(up)).normalized()
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.sensor_height = 24
    data.lens = 12 / math.tan(math.radians(vertical_fov) / 2)
    data.clip_start = 1e-6
    data.clip_end = 1e9
    turned = Matrix((right, right.cross(forward), -forward)).transposed().to_4x4()
    scene = bpy.context.scene
    scene.camera = add(data, "camera", Matrix.Translation(position) @ turned)
    scene.render.resolution_x = width
    scene.render.resolution_y = height
    scene.render.resolution_percentage = 100


# Every path to its end by roulette alone; no light cut off, no denoising, no pixel left early: unbiased.
def set_up(arguments):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.use_persistent_data = True
    scene.render.film_transparent = False
    if arguments.threads:
        scene.render.threads_mode = "FIXED"
        scene.render.threads = arguments.threads
    settings = scene.cycles
    if arguments.bvh2:
        preferences = bpy.context.preferences
        preferences.experimental.use_cycles_debug = True
        preferences.view.show_developer_ui = True
        settings.debug_bvh_layout = "BVH2"
    settings.device = "CPU"
    settings.samples = arguments.samples
    settings.time_limit = arguments.seconds
    settings.sampling_pattern = "SOBOL"
    settings.pixel_filter_type = "BOX"
    settings.filter_width = 1
    settings.film_exposure = 1
    settings.blur_glossy = 0
    settings.sample_clamp_direct = 0
    settings.sample_clamp_indirect = 0
    settings.light_sampling_threshold = 0
    settings.min_light_bounces = 0
    settings.use_adaptive_sampling = False
    settings.use_denoising = False
    settings.use_fast_gi = False
    settings.use_guiding = False
    settings.caustics_reflective = True
    settings.max_bounces = 1024
    settings.diffuse_bounces = 1024
    image = scene.render.image_settings
    image.file_format = "OPEN_EXR"
    image.color_mode = "RGB"
    image.color_depth = "32"
    image.exr_codec = "ZIP"
    scene.render.use_file_extension = False
    scene.render.dither_intensity = 0
    scene.view_settings.view_transform = "Raw"


def render():
    parser = argparse.ArgumentParser(prog="blender -b --python-exit-code 1 --python FILE --")
    parser.add_argument("--samples", type=int, default=256, help="paths a pixel (256)")
    parser.add_argument("--seconds", type=float, default=0, help="stop at this time, at less samples")
    parser.add_argument("--seed", type=int, default=1, help="first seed (1)")
    parser.add_argument("--seeds", type=int, default=1, help="number of pictures, each with the next seed (1)")
    parser.add_argument("--threads", type=int, default=0, help="0 for all cores")
    parser.add_argument("--bvh2", action="store_true", help="Cycles' own ray tracer in place of Embree")
    parser.add_argument("--out", required=True, help="EXR file, 32-bit linear Rec.709; {} stands for the seed")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    set_up(arguments)
    scene = bpy.context.scene
    for seed in range(arguments.seed, arguments.seed + arguments.seeds):
        scene.cycles.seed = seed
        scene.render.filepath = os.path.abspath(arguments.out.replace("{}", str(seed)))
        wall, processor = time.perf_counter(), time.process_time()
        bpy.ops.render.render(write_still=True)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        print(f"rendered {scene.render.filepath}: seconds {wall:.2f} processor {processor:.2f}", flush=True)
