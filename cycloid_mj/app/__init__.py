"""The designer's page in the browser: requirements, parameters, results and exports of a drive on this computer.

This package owns what the page shows and how. Every figure comes from the packages below, and JavaScript computes none:
it shows what the server returns. The server is starlette with uvicorn, bound to localhost.
"""
