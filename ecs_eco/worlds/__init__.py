"""The worlds that come with the package, a folder each, and how a world is built from its file."""
