"""The viewer: a page in the browser that shows a living world or a recorded run, and the server for it.

Nothing here changes a world, except by its interventions. The page is in `static`; the sources of its
vendor.js are in view-page/ at the root.
"""
