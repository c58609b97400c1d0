"""Checks that MuJoCo draws by the display lists that baked light relies on."""

import functools

import mujoco
import numpy as np

from mjsim.errors import OpenGLError
from mjsim.light import ALWAYS, BakedLight, LightGroup, LightProbes, LitSurface
from mjsim.progress import say
from mjsim.sim.gl_calls import GlCalls
from mjsim.sim.lit_scene import LitScene
from mjsim.sim.opengl import make_context
from mjsim.sim.scene_geoms import same_layout

WIDTH, HEIGHT = 24, 8
SCENE = f"""
<mujoco>
  <visual><global offwidth="{WIDTH}" offheight="{HEIGHT}"/><quality shadowsize="1" offsamples="0"/></visual>
  <asset><mesh name="square" vertex="-1 -1 0  1 -1 0  1 1 0  -1 1 0  0 0 -0.1"/></asset>
  <worldbody>
    <light dir="0 0 -1" diffuse="0 0 0" ambient="1 1 1"/>
    <camera name="above" pos="0 0 8" fovy="14.2501"/>
    <geom type="box" size="1 1 1" pos="-2 0 -1" rgba="1 1 1 1"/>
    <geom type="plane" size="1 1 1" rgba="1 1 1 1"/>
    <geom type="box" size="1 1 1" pos="2 0 -1" rgba="1 1 1 1"/>
  </worldbody>
</mujoco>
"""
