"""Renders a scene that rk_scene_json_write wrote (src/driver/scene_json.h) by Blender's Cycles:

    blender --background --factory-startup --python cycles.py -- SCENE.json PICTURE.exr SAMPLES SEED

Everything that Cycles does beyond the scene is switched off: bounces, its pixel filter, clamping, denoising,
and the threshold below which it leaves light out."""

import json
import sys

import bpy
from mathutils import Matrix


def clear():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")


def material(name, kind, colour, strength=None):
    """A material of one shader node."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader = nodes.new(kind)
    shader.inputs["Color"].default_value = (*colour, 1)
    if strength is not None:
        shader.inputs["Strength"].default_value = strength
    output = nodes.new("ShaderNodeOutputMaterial")
    made.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def add_mesh(name, vertices, faces, materials):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    for one in materials:
        mesh.materials.append(one)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(thing)
    return thing


def add_object(name, described, materials, shutter):
    corners = described["vertices"]
    faces = [(i, i + 1, i + 2) for i in range(0, len(corners), 3)]
    thing = add_mesh(name, corners, faces, materials)
    for face, number in zip(thing.data.polygons, described["triangle_materials"]):
        face.material_index = number
    if described["path"]:
        animate(thing, described["path"], shutter["open"], shutter["close"])


def animate(thing, path, start, end):
    """The path in frames 1 to 2: a cubic is a Bezier curve, along which time is linear if the handles stand
    at a third and two thirds of it. Cycles reads times from a table of 256 that ends at 255/256, with weights
    that end at 255/256, too (util_cdf_inverted, lookup_table_read); its frame is longer than our shutter by
    as much."""
    end = start + (end - start) * (256 / 255) ** 2
    a, b, c = path
    curves = ((lambda x: x, lambda x: 1.0),
              (lambda x: a * x**3 + b * x**2 + c * x, lambda x: 3 * a * x**2 + 2 * b * x + c))
    third = (end - start) / 3
    thing.animation_data_create()
    thing.animation_data.action = bpy.data.actions.new("path")
    for axis, (value, slope) in enumerate(curves):
        points = thing.animation_data.action.fcurves.new("location", index=axis).keyframe_points
        points.add(2)
        for point, frame, time, side in ((points[0], 1, start, 1), (points[1], 2, end, -1)):
            point.interpolation = "BEZIER"
            point.handle_left_type = point.handle_right_type = "FREE"
            point.co = (frame, value(time))
            point.handle_left = (frame - 1 / 3, value(time) - slope(time) * third)
            point.handle_right = (frame + 1 / 3, value(time) + slope(time) * third)
    thing.cycles.use_motion_blur = True
    thing.cycles.motion_steps = 7  # 65 positions, with straight lines between


def add_light(name, light):
    """A glowing surface of two faces, which shines to both sides and which the camera does not see."""
    at, x, y = light["position"], light["edge01"], light["edge02"]
    corners = [at, [p + q for p, q in zip(at, x)], [p + q + r for p, q, r in zip(at, x, y)],
               [p + q for p, q in zip(at, y)]]
    glow = material(name, "ShaderNodeEmission", light["radiance"], 1)
    thing = add_mesh(name, corners, [(0, 1, 2), (0, 2, 3)], [glow])
    thing.visible_camera = False


def add_camera(scene, described, lens):
    camera = bpy.data.cameras.new("camera")
    thing = bpy.data.objects.new("camera", camera)
    scene.collection.objects.link(thing)
    scene.camera = thing
    right, up, forward = (described[name] for name in ("right", "up", "forward"))
    rows = [[right[i], up[i], -forward[i], described["position"][i]] for i in range(3)]
    thing.matrix_world = Matrix(rows + [[0, 0, 0, 1]])
    camera.sensor_fit = "VERTICAL"
    camera.sensor_height = 24  # millimetres, as the focal length is
    camera.lens = 12 / described["half_height"]
    camera.clip_start = 1e-3
    camera.clip_end = 1e3
    if lens:
        camera.dof.use_dof = True
        camera.dof.focus_distance = lens["focal_distance"]
        # The lens's diameter is the focal length, taken from millimetres to metres, over the f-number.
        camera.dof.aperture_fstop = camera.lens * 1e-3 / lens["diameter"]


def set_up(scene, described, samples, seed):
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = described["width"], described["height"]
    render.resolution_percentage = 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    render.use_motion_blur = described["shutter"] is not None
    render.motion_blur_shutter = 1
    cycles.motion_blur_position = "START"
    scene.frame_set(1)
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.light_sampling_threshold = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.max_bounces = cycles.diffuse_bounces = 0
    cycles.caustics_reflective = cycles.caustics_refractive = False


def main(path, picture, samples, seed):
    with open(path, encoding="utf-8") as file:
        described = json.load(file)
    clear()
    scene = bpy.context.scene
    materials = [material(f"material {i}", "ShaderNodeBsdfDiffuse", one["kd"])
                 for i, one in enumerate(described["materials"])]
    for i, one in enumerate(described["objects"]):
        add_object(f"object {i}", one, materials, described["shutter"])
    for i, light in enumerate(described["lights"]):
        add_light(f"light {i}", light)
    add_camera(scene, described["camera"], described["lens"])
    set_up(scene, described, int(samples), int(seed))
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


main(*sys.argv[sys.argv.index("--") + 1:])
