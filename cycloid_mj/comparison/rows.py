"""The figures of a comparison, one row each: name, unit, and where it stands in the measures of a run."""

from collections.abc import Callable

from cycloid_mj.comparison.measures import Measures

ROWS: tuple[tuple[str, str, Callable[[Measures], float | None]], ...] = (
    ("transmission error of the output, p-p", "arcsec", lambda m: m.findings.transmission_error.peak_to_peak_arcsec),
    ("play and wind-up of the output, mean", "arcsec", lambda m: m.findings.transmission_error.mean_arcsec),
    ("output speed error, rms", "rad/s", lambda m: m.findings.output_speed.rms_error_rad_s),
    ("vibration of the output, rms acceleration", "rad/s^2", lambda m: m.vibration.output_rad_s2.rms),
    ("efficiency", "%", lambda m: None if m.findings.efficiency is None else 100 * m.findings.efficiency),
    ("transmission error of the gear, p-p", "arcsec", lambda m: m.findings.gear_transmission_error.peak_to_peak_arcsec),
    ("play and wind-up of the gear, mean", "arcsec", lambda m: m.findings.gear_transmission_error.mean_arcsec),
    ("gear speed error, rms", "rad/s", lambda m: m.fluctuation.gear_speed_rad_s.rms),
    ("gear speed error, peak", "rad/s", lambda m: m.findings.gear_speed.peak_error_rad_s),
    ("vibration of the gear centre, rms acceleration", "m/s^2", lambda m: m.vibration.gear_centre_m_s2.rms),
    ("q path error, rms", "um", lambda m: m.findings.q_path.rms_error_um),
    ("q path error, rms, without steady shifts", "um", lambda m: m.fluctuation.q_path_um.rms),
    ("q speed error, rms", "mm/s", lambda m: m.findings.q_speed_magnitude.rms_error_mm_s),
    ("q velocity error, rms, without steady shifts", "mm/s", lambda m: m.fluctuation.q_velocity_mm_s.rms),
    ("contacts in touch, mean", "1", lambda m: m.findings.contact_summary.mean_active),
    ("teeth that carry force, mean", "1", lambda m: m.forces.teeth_mean),
    ("teeth that carry force, least", "1", lambda m: m.forces.teeth_least),
    ("teeth that carry force, most", "1", lambda m: m.forces.teeth_most),
    ("force on the most loaded tooth, mean", "N", lambda m: m.forces.tooth_mean_n),
    ("force on the most loaded tooth, peak", "N", lambda m: m.forces.tooth_peak_n),
    ("force of the cam, mean", "N", lambda m: m.forces.cam_mean_n),
    ("force of the cam, peak", "N", lambda m: m.forces.cam_peak_n),
    ("force of one output pin, peak", "N", lambda m: m.forces.output_pin_peak_n),
    ("penetration, largest", "um", lambda m: m.findings.contact_summary.max_penetration_um),
)
