"""Pictures for notebooks."""

from __future__ import annotations

import base64
import html

from . import _core
from ._arrays import U8


def figure(image: U8, caption: str) -> str:
    """An HTML figure with the picture inside."""
    data = base64.b64encode(_core.encode_png(image)).decode("ascii")
    return (
        '<figure style="margin:0"><img style="max-width:100%" '
        f'src="data:image/png;base64,{data}" alt=""/>'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )
