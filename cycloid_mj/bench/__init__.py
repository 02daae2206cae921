"""Comparison of test-bench measurements with a design: calibration by hysteresis loops, transmission error by order."""

from cycloid_mj.bench.calibration import Calibration, calibrate, compare_losses
from cycloid_mj.bench.loop import MeasuredLoop, measured_loop, read_loop
from cycloid_mj.bench.prediction import Prediction, predict_loops
from cycloid_mj.bench.protocol import Protocol, protocol_of
from cycloid_mj.bench.te import BenchComparison, compare_bench, read_te

__all__ = [
    "BenchComparison",
    "Calibration",
    "MeasuredLoop",
    "Prediction",
    "Protocol",
    "calibrate",
    "compare_bench",
    "compare_losses",
    "measured_loop",
    "predict_loops",
    "protocol_of",
    "read_loop",
    "read_te",
]
