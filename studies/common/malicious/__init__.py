"""Malicious files and messages: worlds, checkpoints, manifests, recordings, policies, search journals, and
messages to the viewer.

Each of them carries a payload that, if it ever runs, leaves a mark: a file in a separate folder.
"""
