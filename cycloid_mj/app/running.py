"""A run of the page's design, with how far it has come."""

from dataclasses import replace

from cycloid_mj.analysis import judge
from cycloid_mj.design import Design
from cycloid_mj.report import report
from cycloid_mj.run import reducer_model, schedule, simulate

TURNS = 1.25
"""Crank turns after the load is on."""
