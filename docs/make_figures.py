"""Draw the figures that the README and the pages show: python docs/make_figures.py."""

from pathlib import Path

import matplotlib as mpl
import numpy as np

from gyrostat.core.units import RPM
from gyrostat.failures import holdable
from gyrostat.identification import identify
from gyrostat.papers.carrara_kuga.dispersed import crossing_figure
from gyrostat.reports import sky_figure
from gyrostat.reports.drawing import STYLE
from gyrostat.reports.figures import friction_figure, record_figure
from gyrostat.spacecraft import read_spacecraft
from gyrostat.telemetry import read_record

ROOT = Path(__file__).parents[1]


def main():
    """Draw an identification, a zero crossing and the sky map of a failure; save the figures."""
    record = read_record(ROOT / "examples" / "wheel_profile2.csv")
    fit = identify(record, inertia=1.5e-3, speed_sigma=5.0 * RPM)
    craft = read_spacecraft(ROOT / "examples" / "three_wheels.toml").spacecraft
    answer = holdable(
        craft, (0.46, -0.04, 0.82), failed={0: 0.28}, boresight=((0.8, 0.0, 0.6), (0.2, -1.0, 0.1))
    )
    drawn = {
        "wheel_profile2": record_figure(
            record, fit.predicted[0], fit.predicted_sigma[0], fit.speed_sigma
        ),
        "wheel_friction": friction_figure(fit),
        "crossing_zero": crossing_figure(),
        "feasible_sky": sky_figure(
            answer.sky, target=np.array([0.2, -1.0, 0.1]), nearest=answer.direction
        ),
    }
    folder = ROOT / "docs" / "images"
    folder.mkdir(exist_ok=True)
    with mpl.rc_context(STYLE):
        for name, figure in drawn.items():
            figure.savefig(folder / f"{name}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
