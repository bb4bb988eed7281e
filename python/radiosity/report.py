"""What a solve says about itself."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

_LIMITS = {
    "accuracy": "the accuracy asked for is reached",
    "max_rays": "the most rays per patch were spent: raise max_rays",
    "patch_size": "light varies too much within patches: use smaller ones",
    "time": "the time was up: raise time_limit, or refine the solution",
    "max_patches": "the mesh has as many patches as it may: raise max_patches",
    "tolerance": "the exchange is as exact as blocks get: use transport='sampled', or fewer patches",
    "memory": "more samples would not fit the memory limit: raise it",
    "samples": "the samples were given: solve the scene afresh for more",
    "solver": "the solver did not converge: the answer is not the equilibrium",
    "hemicubes": "the most hemicubes per patch were drawn: use smaller patches, or another solver",
    "observer": "it was told to stop",
}

_STOPS = {
    "max_iterations": "the iterations are spent",
    "diverged": "it diverged",
    "observer": "it was told to stop",
}


_NOT_COUNTED = " of the light within patches, which does not count for their means"


@dataclass(frozen=True)
class Report:
    """Energy, closure, error and effort of a solve; prints as a table.

    Powers are W per band. The error of irradiance is its root mean square over area and bands relative to its mean;
    ``interval`` holds it nine times in ten, and ``estimated_error`` is its upper end.
    ``causes`` splits it (see :class:`radiosity.Certificate`); it combines ``sampling_error`` (more rays reduce it) and
    ``discretisation_error`` (smaller patches reduce it). ``of_field`` tells whether it is the error of a field that is
    linear over patches, as it is on a mesh of the engine's own, the last of ``meshes``; then ``mesh_error``, what that
    field leaves of the light, is part of it. Otherwise it is the error of the means of patches. ``limited_by`` is
    ``"accuracy"`` when the request was met.
    ``absorbed_by_mirrors`` is the part of ``absorbed`` that surfaces with a mirror reflectance or transmittance take.
    ``unfollowed`` is what goes on between mirrors beyond what is followed; it counts as an error. Both are empty where
    there are no mirrors and no glass.
    ``closure_*`` are raw row sums of the form factors before ``closure_residual`` remained after balancing.

    ``transport`` says what the equations were solved on ("sampled", "hierarchical", "given", "on_demand" for rows drawn
    when they shoot, "shooting" for none), and ``why`` why, where it was left to choose.

    ``solver`` took ``iterations`` (products, sweeps or shots), which is as much work as ``products`` with the whole
    exchange, and stopped because of ``stop``: "converged", "max_iterations", "diverged" or "observer", which is a
    callback that returned False. ``residual_history`` and ``unshot_history`` (power that has arrived but was not sent
    on, as a share of what is emitted; empty where the solver does not know it) are what they were after
    ``history_iterations``, at most 1,024 of them.
    """

    accuracy: float
    estimated_error: float
    interval: tuple[float, float]
    of_field: bool
    mesh_error: float
    causes: dict[str, float]
    sampling_error: float
    discretisation_error: float
    limited_by: str
    patches: int
    sides: int
    luminaires: int
    rays: int
    shadow_rays: int
    rows_on_demand: int
    hemicubes: int
    rounds: int
    solver: str
    iterations: int
    products: float
    residual: float
    converged: bool
    stop: str
    history_iterations: list[int]
    residual_history: list[float]
    unshot_history: list[float]
    emitted: list[float]
    from_lights: list[float]
    absorbed: list[float]
    escaped: list[float]
    lost_on_backs: list[float]
    imbalance: float
    closure_min: float
    closure_mean: float
    closure_max: float
    escape_share: float
    closure_residual: float
    memory_bytes: int
    sampling_seconds: float
    solving_seconds: float
    seconds: float
    seed: int = 0
    bands: list[str] = field(default_factory=list)
    transport: str = "sampled"
    why: str = ""
    meshes: int = 0
    absorbed_by_mirrors: list[float] = field(default_factory=list)
    unfollowed: list[float] = field(default_factory=list)

    @property
    def reached(self) -> bool:
        """Whether the estimated error is within the accuracy asked for."""
        return self.limited_by == "accuracy"

    @property
    def limit(self) -> str:
        """What ended the solve, and what to do about it, in words."""
        return _LIMITS[self.limited_by]

    def to_dict(self, *, timed: bool = True) -> dict[str, Any]:
        """Plain numbers, strings and lists, ready for JSON; not ``timed``, the same for the same seed."""
        items = asdict(self) | {"reached": self.reached}
        if not self.absorbed_by_mirrors:
            del items["absorbed_by_mirrors"], items["unfollowed"]
        return {name: value for name, value in items.items() if timed or not name.endswith("seconds")}

    def rows(self) -> list[tuple[str, str]]:
        """Label and text of each line of the table."""

        def powers(values: list[float]) -> str:
            return "  ".join(f"{name} {v:.4g}" for name, v in zip(self.bands, values, strict=bool(values))) + " W"

        rows = [
            ("estimated error", f"{self.estimated_error:.3%} of the mean irradiance (asked for {self.accuracy:.3%})"),
            ("  by sampling", f"{self.sampling_error:.3%}"),
            ("  by patch size", f"{self.discretisation_error:.3%}"),
            ("  by the mesh", f"{self.mesh_error:.3%}" + ("" if self.of_field else _NOT_COUNTED)),
            ("stopped because", self.limit),
            ("emitted", powers(self.emitted)),
            ("arrived from lights", powers(self.from_lights)),
            ("absorbed", powers(self.absorbed)),
            ("  by mirrors", powers(self.absorbed_by_mirrors) + " by what mirrors or lets light through"),
            ("escaped", powers(self.escaped)),
            ("lost on backs", powers(self.lost_on_backs)),
            ("not followed", powers(self.unfollowed) + " between mirrors"),
            ("energy imbalance", f"{self.imbalance:+.3%}"),
            ("closure", f"raw row sums {self.closure_min:.4f} to {self.closure_max:.4f}, mean {self.closure_mean:.4f};"
                        f" {self.escape_share:.2%} of rays escape"),
            ("transport", self.transport + (f": {self.why}" if self.why else "")),
            ("patches", f"{self.patches:,} ({self.sides:,} sides, {self.luminaires:,} luminaires)"
                        + (f", the last of {self.meshes} meshes" if self.meshes else "")),
            ("rays", f"{self.rays:,} + {self.shadow_rays:,} to luminaires, in {self.rounds} rounds"),
            ("rows on demand", f"{self.rows_on_demand:,} by {self.hemicubes:,} hemicubes, in {self.rounds} rounds"),
            ("solver", f"{self.solver.replace('_', ' ')}, {self.iterations:,} iterations, residual {self.residual:.1e}"
                       + ("" if self.converged else f", NOT converged: {_STOPS[self.stop]}")),
            ("memory", f"{self.memory_bytes / 1e6:.1f} MB"),
            ("time", f"{self.seconds:.2f} s"
                     f" (sampling {self.sampling_seconds:.2f}, solving {self.solving_seconds:.2f})"),
        ]  # fmt: skip
        present = {
            "arrived from lights": any(self.from_lights),
            "lost on backs": any(self.lost_on_backs),
            "  by mirrors": any(self.absorbed_by_mirrors),
            "not followed": any(self.unfollowed),
            "rows on demand": self.rows_on_demand > 0,
            "  by the mesh": self.mesh_error > 0,
        }
        return [row for row in rows if present.get(row[0], True)]

    def __str__(self) -> str:
        rows = self.rows()
        width = max(len(label) for label, _ in rows)
        return "\n".join(f"{label:<{width}}  {text}" for label, text in rows)
