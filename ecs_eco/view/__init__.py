"""The viewer: a browser page that shows a live world or a recorded run, and its server.

The viewer changes a world only through interventions. The page is in `static`; the sources of its vendor.js
are in view-page/ at the repository root.
"""
