"""A world of lambs and ewes, and the systems that only it needs: lamb.toml, README.md."""
