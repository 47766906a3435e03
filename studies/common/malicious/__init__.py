"""Malicious files and messages: worlds, checkpoints, manifests, recordings, policies,
journals of searches, messages to the viewer.

Each carries a payload that leaves a mark, a file in a folder of its own, if it ever runs.
"""
