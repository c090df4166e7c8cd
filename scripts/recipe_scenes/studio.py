# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Studio: products, links, lamps beside Cycles."""

from __future__ import annotations

import bpy
from scenery.materials import Graph, principled
from scenery.modelling import add, box, smooth_profile, turned
from scenery.staging import aimed, camera, light, world

from . import surfaces
from .stage import pattern, preset, recipe, shine


def head(name: str, material, location, size: float = 0.5, turn: float = 0.0) -> bpy.types.Object:
    """Blender's monkey, smooth."""
    bpy.ops.mesh.primitive_monkey_add(size=2.0 * size, location=location)
    made = bpy.context.active_object
    made.name = name
    made.rotation_euler = (-0.1, 0.0, turn)
    made.data.shade_smooth()
    modifier = made.modifiers.new("Smooth", "SUBSURF")
    modifier.levels, modifier.render_levels = 1, 2
    made.data.materials.append(material)
    return made


@recipe("Softbox for a product", samples=48, gallery=True)
def softbox(scene) -> None:
    """A bottle stands between two soft panels. Their long reflections show its shape.

    1. Choose Add > Light > SDF Lamp > Presets > **Soft Panel**. Set *Width* to 0.4 m and *Depth* to 1.2 m.
    2. Put it to the left of the bottle, and turn it to the bottle. Set *Power* to 60 W and *Temperature* to 5600 K.
    3. Press Alt D, and put the copy to the right. Turn *Visible to Camera* off.
    4. Add the preset **Ring Light** behind the bottle, with a *Power* of 10 W and the *Color* 1, 0.45, 0.14.
    """
    world((0.01, 0.01, 0.012))
    surfaces.backdrop(principled("Backdrop", (0.06, 0.065, 0.075), 0.35), 1.4)
    amber = Graph("Perfume")
    amber.finish(amber.node("ShaderNodeBsdfGlass", Color=(0.98, 0.62, 0.2), IOR=1.36))
    clear = surfaces.glass("Glass", (0.98, 0.99, 1.0))
    gold = surfaces.metal("Gold", (0.9, 0.62, 0.25), 0.15)
    outer = box("Bottle", (0.34, 0.16, 0.42), 0.03, 5)
    add("Bottle", outer, clear, location=(0.0, 0.0, 0.29), rotation=(0, 0, 18))
    add(
        "Perfume",
        box("Perfume", (0.29, 0.115, 0.30), 0.02, 4),
        amber.material,
        location=(0.0, 0.0, 0.265),
        rotation=(0, 0, 18),
    )
    neck = [(0.0, 0.0), (0.045, 0.0), (0.045, 0.05), (0.0, 0.05)]
    add("Neck", turned("Neck", neck), gold, location=(0.0, 0.0, 0.5))
    cap = smooth_profile([(0.0, 0.0), (0.07, 0.0), (0.078, 0.01), (0.078, 0.13), (0.07, 0.142), (0.0, 0.142)], 6)
    add("Cap", turned("Cap", cap, 64), principled("Cap", (0.012, 0.012, 0.014), 0.08), location=(0.0, 0.0, 0.55))
    podium = turned("Podium", [(0.0, 0.0), (0.42, 0.0), (0.42, 0.075), (0.412, 0.08), (0.0, 0.08)], 96)
    add("Podium", podium, principled("Podium", (0.02, 0.02, 0.022), 0.12), location=(0.0, 0.0, 0.0))
    pebble = smooth_profile([(0.0, -0.5), (0.8, -0.3), (1.0, 0.0), (0.8, 0.3), (0.0, 0.5)], 5)
    black = surfaces.stone("Pebble", (0.08, 0.08, 0.085), 8.0, 0.02)
    for x, y, size in ((-0.62, 0.12, 0.13), (-0.56, -0.12, 0.08), (0.62, 0.18, 0.16), (0.6, -0.12, 0.09)):
        add("Pebble", turned("Pebble", pebble, 32), black, location=(x, y, 0.4 * size), scale=(size, 1.2 * size, size))
    first = preset("panel", (-0.95, 0.1, 0.55), width=0.4, depth=1.2, thickness=0.05)
    first.rotation_euler = aimed((-0.95, 0.1, 0.55), (0.0, 0.0, 0.4))
    shine(first, 60.0, kelvins=5600.0, camera=0.1)
    second = first.copy()
    second.location = (1.0, 0.25, 0.6)
    second.rotation_euler = aimed((1.0, 0.25, 0.6), (0.0, 0.0, 0.35))
    scene.collection.objects.link(second)
    for panel in (first, second):
        panel.data.sdf_lamp.visible_camera = False
    shine(preset("ring_light", (0.0, 1.18, 0.62), scale=1.15), 10.0, (1.0, 0.45, 0.14), camera=0.12)
    camera((0.0, -2.3, 0.62), (0.0, 0.0, 0.4), 30.0)


@recipe("Light linking", samples=48)
def light_linking(scene) -> None:
    """Each lamp lights one head. Both lamps light the ground.

    1. Add two heads, and the presets **Neon Ring** and **Fluorescent Tube** between them.
    2. Select a lamp. Choose Object Properties > Shading > Light Linking > **New**.
    3. Drag one head and the ground from the Outliner into the list.
    4. Do the same for the other lamp and the other head.
    """
    world((0.004, 0.004, 0.006))
    ground = surfaces.backdrop(principled("Backdrop", (0.22, 0.22, 0.24), 0.45), 1.5)
    clay = principled("Clay", (0.55, 0.53, 0.5), 0.35)
    heads = [
        head("Left Head", clay, (-0.62, 0.0, 0.52), 0.5, 0.35),
        head("Right Head", clay, (0.62, 0.0, 0.52), 0.5, -0.35),
    ]
    ring = preset("neon_ring", (0.0, -0.35, 1.3), scale=0.6)
    shine(ring, 60.0, (1.0, 1.0, 1.0), camera=0.1)
    pattern(ring, "neon", tint=(1.0, 0.12, 0.03), whiteness=0.4)
    tube = preset("tube", (0.0, -0.85, 0.05), scale=0.7)
    shine(tube, 30.0, (0.06, 0.3, 1.0), camera=0.12)
    for made, seen in ((ring, heads[0]), (tube, heads[1])):
        collection = bpy.data.collections.new(f"Lit by {made.name}")
        for thing in (seen, ground):
            collection.objects.link(thing)
        made.light_linking.receiver_collection = collection
    camera((0.0, -3.4, 1.05), (0.0, 0.1, 0.62), 38.0)


@recipe("Lamps in a render of Cycles", samples=64)
def beside_cycles(scene) -> None:
    """Cycles renders the scene, and this engine adds the light of the lamps.

    1. Keep the render engine **Cycles**, and add the presets **Filament** and **Light Cage**.
    2. Select a lamp, and choose Data > SDF Lamp > **Add Lamps' Light to Cycles**. This makes a second scene, which
       renders the light of the lamps. The compositor adds it to the picture of Cycles.
    3. Press F12.
    4. If you add objects later, press **Update Lamps' Light in Cycles**.
    """
    world((0.02, 0.03, 0.06))
    surfaces.floor(surfaces.wood("Floor", (0.34, 0.25, 0.18), (0.22, 0.15, 0.1)), (9.0, 9.0))
    surfaces.wall(principled("Plaster", (0.45, 0.44, 0.42), 0.9), 1.6, (9.0, 4.0))
    skin = principled("Skin", (0.5, 0.3, 0.2), 0.4, Subsurface_Weight=0.4, Subsurface_Scale=0.05)
    plinth = surfaces.stone("Plinth", (0.4, 0.39, 0.37), 2.0, 0.01)
    add("Plinth", box("Plinth", (0.7, 0.7, 0.5), 0.015), plinth, location=(0.0, 0.2, 0.25))
    head("Bust", skin, (0.0, 0.2, 0.98), 0.5, 0.15)
    light("Window", "AREA", 45.0, (-2.8, -1.2, 2.4), (0.0, 0.2, 0.9), (0.55, 0.75, 1.0), size=1.6)
    shine(preset("cage", (0.95, -0.2, 0.42), (0, 0, 25), 0.9), 30.0, kelvins=3000.0, camera=0.1)
    shine(preset("spring", (-0.95, 0.0, 0.42), scale=1.4), 14.0, (1.0, 0.3, 0.06), camera=0.03)
    camera((0.25, -3.4, 1.35), (0.02, 0.2, 0.78), 38.0)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = (
        scene.sdf_lights.samples,
        True,
        False,
    )
    bpy.ops.object.select_all(action="DESELECT")
    bpy.ops.sdf_lights.beside_cycles_add()
