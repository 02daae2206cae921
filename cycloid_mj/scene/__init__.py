"""Poses of the parts and contact forces of a logged run, from its columns, and the messages that viewers show.

The package converts a design and columns of samples to poses, contact forces and Foxglove messages. It needs neither
MuJoCo nor a log: writers of logs take a `Scene`, plots take `poses` and `contact_forces`.
"""

from cycloid_mj.scene.drawing import (
    Drawing,
    Separations,
    drawn_radii,
    fitting_magnification,
    largest_magnification,
    magnify_gaps,
    measure_gaps,
    ring_outline,
    widest_gap,
)
from cycloid_mj.scene.force import ContactForces, cams, contact_forces, ideal_forces, reference_force
from cycloid_mj.scene.messages import RATE, Scene, frame_rate
from cycloid_mj.scene.pose import pose_columns, poses, ring_places, transform
from cycloid_mj.scene.rv_drawing import RvDrawing, draw_rv_poses

__all__ = [
    "RATE",
    "ContactForces",
    "Drawing",
    "RvDrawing",
    "Scene",
    "Separations",
    "cams",
    "contact_forces",
    "draw_rv_poses",
    "drawn_radii",
    "fitting_magnification",
    "frame_rate",
    "ideal_forces",
    "largest_magnification",
    "magnify_gaps",
    "measure_gaps",
    "pose_columns",
    "poses",
    "reference_force",
    "ring_outline",
    "ring_places",
    "transform",
    "widest_gap",
]
