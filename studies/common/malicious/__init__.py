"""Malicious files and messages: worlds, checkpoints, manifests, recordings, policies, search journals, and
messages to the viewer.

Each carries a payload that leaves a mark if it ever runs: a file in a separate folder.
"""
