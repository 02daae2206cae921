"""A page in the browser on this machine: a design under sliders, redrawn, checked and solved while they move.

This room owns what the page shows and how. Every figure comes from the rooms below; no formula lives in JavaScript.
"""
