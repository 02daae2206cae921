"""The scene around a reducer: lights, cameras and a background. It changes nothing in the mechanics."""

from cycloid_mj.reducer import Reducer

_SCENE = """<mujoco model="{name} scene">
  <include file="{reducer}"/>

  <statistic center="0 0 0" extent="{extent}"/>

  <visual>
    <headlight ambient="0.3 0.3 0.3" diffuse="0.25 0.25 0.25" specular="0.1 0.1 0.1"/>
    <global azimuth="105" elevation="-60" offwidth="1920" offheight="1080"/>
    <quality shadowsize="4096"/>
  </visual>

  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.97 0.98 0.99" rgb2="0.62 0.68 0.75" width="512" height="512"/>
  </asset>

  <worldbody>
    <light name="output_side" pos="{far} {far} {high}" dir="-1 -1 -2" diffuse="0.45 0.45 0.45" specular="0.2 0.2 0.2"/>
    <light name="input_side" pos="-{far} {far} -{high}" dir="1 -1 2" diffuse="0.45 0.45 0.45" specular="0.2 0.2 0.2"/>
    <camera name="input_side" pos="0 0 -{away}" xyaxes="-1 0 0 0 1 0" fovy="35"/>
    <camera name="output_side" pos="0 0 {away}" xyaxes="1 0 0 0 1 0" fovy="35"/>
    <camera name="oblique" pos="{side} {rise} -{front}" mode="targetbody" target="housing" fovy="35"/>
  </worldbody>
</mujoco>
"""


def scene_xml(reducer: Reducer, model_file: str) -> str:
    """Return the MJCF of a scene with lights, cameras and background that includes the file named `model_file`."""
    design = reducer.design
    housing_radius = design.housing.outer_radius
    lengths = {
        "extent": 2.2 * housing_radius,
        "far": 4.0 * housing_radius,
        "high": 8.0 * housing_radius,
        "away": 4.0 * housing_radius,
        "side": 1.6 * housing_radius,
        "rise": 1.4 * housing_radius,
        "front": 3.0 * housing_radius,
    }
    return _SCENE.format(
        name=design.name, reducer=model_file, **{key: f"{value:.6g}" for key, value in lengths.items()}
    )
