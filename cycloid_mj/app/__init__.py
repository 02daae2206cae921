"""A page in the browser on this machine: where a drive is asked for, shaped, looked at from all sides, and made.

This room owns what the page shows and how. Every figure comes from the rooms below; no formula lives in JavaScript:
the page places what it is given, and asks again. It needs nothing but Python's own HTTP server.
"""
