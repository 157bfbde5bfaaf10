"""Recordings, HTML viewer, pictures, plots."""

from __future__ import annotations

from ._dualbody import Live, Pictures, Plot, Recording

__all__ = ["Live", "Page", "Pictures", "Plot", "Recording"]


class Page:
    """An HTML viewer in a frame of given size; notebooks show it inline, also offline."""

    def __init__(self, html: str, width: str = "100%", height: str = "480") -> None:
        self.html, self.width, self.height = html, width, height

    def _repr_html_(self) -> str:
        escaped = self.html.replace("&", "&amp;").replace('"', "&quot;")
        size = f'width="{self.width}" height="{self.height}"'
        return f'<iframe srcdoc="{escaped}" {size} style="border:0" allow="fullscreen"></iframe>'
