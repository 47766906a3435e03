"""Malicious files and messages: worlds, checkpoints, manifests, recordings, policies, search journals, and
messages to the viewer.

Each carries a payload that leaves a mark, a file in a separate folder, if it ever runs.
"""
