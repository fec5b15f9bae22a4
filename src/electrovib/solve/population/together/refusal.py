"""The reason why fingers are not computed together."""

from __future__ import annotations


class NotTogetherError(Exception):
    """A scenario, or what differs between fingers, that arrays over fingers do not cover; the message is the reason."""
