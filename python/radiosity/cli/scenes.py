"""``radiosity scenes``."""

from __future__ import annotations

from radiosity.cli import options, output, source


def scenes(as_json: options.AsJson = False) -> None:
    """List the built-in scenes; use them wherever a FILE is, as builtin:NAME."""
    from radiosity.scenes import BUILTIN_SCENES

    described = {name: (make.__doc__ or "").partition("\n")[0] for name, make in BUILTIN_SCENES.items()}
    if as_json:
        output.print_json(described)
        return
    width = max(map(len, described)) + len(source.BUILTIN)
    for name, description in described.items():
        print(f"{source.BUILTIN + name:<{width}}  {description}")
