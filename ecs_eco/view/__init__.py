"""The viewer: a page in the browser that shows a living world, or a recorded run, and a server for it on this machine.

Nothing here changes a world, except by its interventions.
"""
