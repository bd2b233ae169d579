"""From a recording in memory to a prediction and a controller; checked by ``mypy --strict`` and run by CI.

python examples/rig.py ../sma-cli/bundled
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import sma


def heated(duration_s: float, dt_s: float, current_a: float) -> dict[str, np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """A drive that is on for the middle third, with the columns of a recording."""
    time_s = dt_s * np.arange(round(duration_s / dt_s), dtype=np.float64)
    on = (time_s > duration_s / 3) & (time_s < 2 * duration_s / 3)
    return {"time_s": time_s, "current_a": np.where(on, current_a, 0.0)}


def main(folder: Path) -> None:
    """Identify, simulate, and say what came out."""
    rig: sma.Identified = sma.identify(folder / "rod.toml", train=folder / "train.csv", validate=folder / "validate.csv")
    if not rig.usable:
        sys.exit(f"not to be used: {'; '.join(rig.notes)}")
    tau: sma.Parameter = rig["tau_s"]
    print(tau)
    print(f"error {rig.train_rmse:.4f} {rig.output_unit}; largest {np.abs(rig.series[0].residuals).max():.4f}")
    prediction = sma.simulate(rig, drive=heated(90.0, 0.2, 4.0))
    print(f"at 4 A it moves to {prediction['displacement_mm'].max():.2f} mm")
    try:
        sma.simulate(rig, drive={"time_s": [0.0, 1.0, 2.0], "current_a": [0.0, float("inf"), 0.0]})
    except sma.InputError as error:
        print(f"row {error.row} of {error.column} is refused: {error}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
