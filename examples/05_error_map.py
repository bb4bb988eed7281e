"""How wrong is it, and where? The error that a solution estimates of itself beside the one it has."""

import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.picture import legend_of, render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

patches = radiosity.scenes.cornell_box().patches(count=2000)
solution = radiosity.solve(patches, accuracy=0.05, seed=1)
better = radiosity.solve(patches, accuracy=0.005, seed=2)  # other rays: its errors have nothing to do with those
deviation = solution.irradiance - better.irradiance


def relative_rms(values: np.ndarray) -> float:
    """Root mean square over area and bands, relative to the mean irradiance."""
    mean = np.average(solution.irradiance, weights=patches.area, axis=0).mean()
    return float(np.sqrt(np.average(values**2, weights=patches.area, axis=0).mean()) / mean)


low, high = solution.report.interval
print(f"asked {solution.report.accuracy:.2%}, estimated {relative_rms(solution.error):.2%}: {low:.2%} to {high:.2%}")
print(f"difference from the better solution {relative_rms(deviation):.2%}")
assert low < relative_rms(solution.error) < high == solution.report.estimated_error
assert 0.8 < relative_rms(deviation) / solution.report.estimated_error < 1.25

# Patch by patch an estimate from four replicates: deviations over it follow Student's t with three degrees of freedom.
lit = better.irradiance.min(axis=1) > 0
beyond = np.mean(np.abs(deviation[lit]) > 3 * solution.error[lit])
print(f"beyond three standard errors: {beyond:.1%} of values; Student's t with three degrees of freedom: 5.8 %")
assert beyond < 1.5 * 0.0577

for name in ("irradiance", "error"):
    low_high = save_image(
        OUT / f"cornell_{name}.png", render(solution, width=500, height=500, show=name, mode="patches"),
        false_colours=True, legend=legend_of(name),
    )  # fmt: skip
    print(f"{name}: colours from {low_high[0]:.3g} to {low_high[1]:.3g} W/m2")
