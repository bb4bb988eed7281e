"""What a form factor is, in pictures: Nusselt's analog and the item buffer of a hemicube.

    >>> from radiosity import teaching
    >>> figure = teaching.draw_nusselt((0, 0, 0), (0, 0, 1), [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    >>> figure.savefig("nusselt.png")

Numbers come from the engine's own kernels. Drawing needs matplotlib: ``pip install 'radiosity[plots]'``.
"""

from radiosity.teaching.hemicube import BACK, NOTHING, ItemBuffer, delta_form_factors, draw_item_buffer, item_buffer
from radiosity.teaching.nusselt import draw_nusselt, frame, nusselt_form_factor, nusselt_outline

__all__ = [
    "BACK",
    "NOTHING",
    "ItemBuffer",
    "delta_form_factors",
    "draw_item_buffer",
    "draw_nusselt",
    "frame",
    "item_buffer",
    "nusselt_form_factor",
    "nusselt_outline",
]
