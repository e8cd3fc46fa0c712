"""Draw the figures that the README and the pages show: python docs/make_figures.py."""

import re
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from gyrostat import allan, budget, campaign, place, simulate
from gyrostat.campaigns import Store
from gyrostat.core.units import RPM
from gyrostat.failures import holdable
from gyrostat.identification import StoredFit, analyse_lot, identify
from gyrostat.identification.gyro.parameters import PARAMETERS
from gyrostat.identification.gyro.simulate import simulated_rates
from gyrostat.monitoring import WheelMonitor
from gyrostat.monitoring.change.assess import Limit, assess, reference_to
from gyrostat.monitoring.change.detector import AlarmSettings
from gyrostat.monitoring.fleet.faults.coulomb_growth import CoulombGrowth
from gyrostat.monitoring.fleet.flight import Cell, Fleet, Flight
from gyrostat.monitoring.fleet.known import known_wheels
from gyrostat.monitoring.fleet.pointing import LOW, SLEWS
from gyrostat.monitoring.fleet.sampling import Sampling, sample
from gyrostat.monitoring.fleet.vehicle import SMALL
from gyrostat.monitoring.rehearsal import samples_of
from gyrostat.papers.carrara_kuga.dispersed import crossing_figure
from gyrostat.reports import friction_charts, record_charts, sky_chart
from gyrostat.reports.allan import allan_figure
from gyrostat.reports.body_sky_map import body_sky_chart
from gyrostat.reports.campaign_charts import histograms, scatter_plots
from gyrostat.reports.chart_frame import WIDTH
from gyrostat.reports.colours import BAND, MARK, MODEL
from gyrostat.reports.drawing import STYLE
from gyrostat.reports.health_charts import health_charts, shade
from gyrostat.reports.health_series import wheel_series
from gyrostat.reports.lot import histograms as lot_histograms
from gyrostat.reports.mode_chart import mode_chart
from gyrostat.reports.mode_diagram import mode_diagram, modes_content
from gyrostat.scenario import Scenario
from gyrostat.scenario.timeline import modes
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft import read_spacecraft
from gyrostat.telemetry import read_record

ROOT = Path(__file__).parents[1]
TEMPLATES = ROOT / "src" / "gyrostat" / "reports" / "templates"


MARGIN = 14
"""Room for the last tick at the right edge of an image."""


def stiff_wheel_figure(scenario: Scenario) -> Figure:
    """Wheel speeds over an orbit without and with null-space control; the forbidden bands."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    laws = {"constant bias": {"controller.null_space_gain": 0.0}, "bands and wear": {}}
    for axes, (title, changes) in zip(
        figure.subplots(1, 2, sharey=True), laws.items(), strict=True
    ):
        flown = simulate(scenario.replace(**changes))
        for name, speed in zip(scenario.wheels, flown.wheel_speed.values.T / RPM, strict=True):
            style = {"color": MARK, "lw": 1.6} if name == "b" else {"color": MODEL, "lw": 0.8}
            axes.plot(flown.time / 60.0, speed, **style)
        for band in ("zero", "resonance"):
            low, high = (scenario.values[f"controller.band.{band}.{e}"] for e in ("above", "below"))
            for ends in ((low, high), (-high, -low)):
                axes.axhspan(*(end / RPM for end in ends), color=BAND, lw=0.0, zorder=0)
        axes.set(title=title, xlabel="time (min)", xlim=(0.0, scenario.duration / 60.0))
    figure.axes[0].set_ylabel("wheel speed (rpm)")
    return figure


def error_budget_figure(folder: Path) -> Figure:
    """Error budget of the cubesat whose wheels pass through zero speed."""
    scenario = ROOT / "examples" / "scenarios" / "zero_crossing_model.toml"
    required = [
        {"index": "APE", "value": "0.06 deg", "level": 0.95},
        {"index": "RPE", "value": "30 arcsec", "level": 0.95, "window": "10 s"},
    ]
    return budget(scenario, folder / "budget", runs=128, requirements=required).plot()


def campaign_charts(folder: Path) -> list[list[Markup]]:
    """Error of 1000 runs whose wheels pass through zero speed, and its strongest driver."""
    path = ROOT / "examples" / "scenarios" / "zero_crossing_model.toml"
    campaign(path, runs=1000, seed=1, out=folder / "campaign")
    scenario, columns = read_scenario(path), Store(folder / "campaign").columns()
    shown = {"error_p99.7": ["wheel.d.coulomb"]}
    bars = [chart.svg() for chart in histograms(scenario, columns, shown)]
    return [bars, scatter_plots(scenario, columns, shown)["error_p99.7"]]


def flying_wheel_charts() -> list[list[Markup]]:
    """History of a simulated wheel whose Coulomb torque grows by 15 % within 30 days."""
    fault = CoulombGrowth(wheel=1, day=25.0, size=0.15, duration=30.0)
    fleet = Fleet(Cell(SMALL, LOW, SLEWS), [Flight(5, (fault,))])
    sampling = Sampling(period=2.0)
    monitor = WheelMonitor(known_wheels(SMALL, sampling))
    for (day,) in fleet.days(60):
        monitor.add(samples_of(sample(day, SMALL, sampling), SMALL))
    table, settings = monitor.windows().wheel("wheel2"), AlarmSettings()
    reference = reference_to(monitor.known.wheels[1])
    (condition,) = assess(table, settings, {"wheel2": reference}, {"wheel2": Limit(9e-5)})
    series = wheel_series(table, condition)
    charts = health_charts(series, condition, settings.threshold, shade([series]), "wheel2")
    return [charts[0::2], charts[1::2]]


def safe_mode_charts(folder: Path) -> list[list[Markup]]:
    """Modes of the nominal run of the safe mode, and transitions of 200 runs."""
    scenario = read_scenario("safe_mode")
    run = simulate(scenario)
    history = {str(name): run[name].to_numpy() for name in run.variables}
    flown = mode_chart(modes(scenario.parts), history)
    assert flown is not None
    flown.level(scenario.values["event.loss.time"], "wheel b is lost", "event", across=False)
    campaign(scenario, runs=200, seed=31, out=folder / "safe_mode")
    content = modes_content(scenario, Store(folder / "safe_mode").columns())
    assert content is not None
    return [[flown.svg(), mode_diagram(scenario, content)]]


def image_of(columns: Sequence[Sequence[Markup]]) -> str:
    """Columns of charts as an SVG image of its own, in the light colours of the pages."""
    colours = re.search(r":root {.*?}", (TEMPLATES / "base.html").read_text("utf-8"), re.DOTALL)
    assert colours is not None
    style = colours[0] + (TEMPLATES / "chart.css").read_text("utf-8")
    parts, below = [], 0
    for k, column in enumerate(columns):
        top = 0
        for chart in column:
            height = int(chart.split('"', 4)[3].split()[3])
            place = f'x="{k * WIDTH}" y="{top}" width="{WIDTH}" height="{height}"'
            parts.append(chart.replace("<svg", Markup(f"<svg {place}"), 1))
            top += height
        below = max(below, top)
    wide = WIDTH * len(columns) + MARGIN
    size = f'width="{wide}" height="{below}" viewBox="0 0 {wide} {below}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}><style>{style} '
        f".chart {{ width: {WIDTH}px; }} "
        f"@media (max-width: {WIDTH - 1}px) {{ .chart {{ font-size: 15px; }} }}</style>"
        '<path d="M0 0H9999V9999H0Z" fill="#fff"/>'
        f"{''.join(parts)}</svg>\n"
    )


def gyro_figure() -> Figure:
    """Allan deviation of 12 h of a simulated gyro, of which the page on its noise gives the fit."""
    sheet = {"quantisation": 1.0, "angle_walk": 0.01, "bias_instability": 0.05, "bias_walk": 0.05}
    truth = {name: value * PARAMETERS[name].factor for name, value in sheet.items()}
    rate = simulated_rates(truth, 432_000, 0.1, np.random.default_rng(3))
    return allan_figure(allan(rate, interval=0.1))


def lot_figure() -> Figure:
    """Histograms of a lot of 40 simulated wheels whose true values are log-normal."""
    random = np.random.default_rng(4)
    median, spread = np.array([0.9e-3, 4.8e-6]), np.array([0.2, 0.1])
    error = 0.5 * spread * median
    true = median * np.exp(spread * random.standard_normal((40, 2)))
    fits = [
        StoredFit(
            name=f"FITS/{k:02d}/fit.json",
            model="stribeck",
            names=("coulomb", "viscous"),
            units=("N·m", "N·m·s/rad"),
            values=values,
            covariance=np.diag(error**2),
            tolerances={},
            inertia=1.5e-3,
            serial=f"RW-{k:03d}",
            date=None,
            temperature=None,
        )
        for k, values in enumerate(true + error * random.standard_normal((40, 2)))
    ]
    options = {"shape": "unknown", "content": 0.95, "confidence": 0.95, "set_size": 4}
    labels = [fit.serial for fit in fits]
    return lot_histograms(
        analyse_lot(fits, labels, best=("lowest", "coulomb"), same_bench=False, **options)
    )


def main():
    """Draw an identification, crossings, a sky map and an orbit with a stiff wheel; save them."""
    record = read_record(ROOT / "examples" / "wheel_profile2.csv")
    fit = identify(record, inertia=1.5e-3, speed_sigma=5.0 * RPM)
    craft = read_spacecraft(ROOT / "examples" / "three_wheels.toml").spacecraft
    answer = holdable(
        craft, (0.46, -0.04, 0.82), failed={0: 0.28}, boresight=((0.8, 0.0, 0.6), (0.2, -1.0, 0.1))
    )
    stiff = read_scenario(ROOT / "examples" / "scenarios" / "stiff_wheel.toml")
    with TemporaryDirectory() as scratch:
        budget_figure = error_budget_figure(Path(scratch))
        safe_mode = safe_mode_charts(Path(scratch))
        of_campaign = campaign_charts(Path(scratch))
    drawn = {
        "crossing_zero": crossing_figure(),
        "error_budget": budget_figure,
        "gyro_allan": gyro_figure(),
        "lot": lot_figure(),
        "stiff_wheel": stiff_wheel_figure(stiff),
    }
    charts = {
        "wheel_profile2": record_charts(
            record, fit.predicted[0], fit.predicted_sigma[0], fit.speed_sigma
        ),
        "wheel_friction": friction_charts(fit),
        "wheel_health": flying_wheel_charts(),
        "safe_mode": safe_mode,
        "campaign": of_campaign,
    }
    folder = ROOT / "docs" / "images"
    folder.mkdir(exist_ok=True)
    star = np.array([0.2, -1.0, 0.1])
    sky = sky_chart(answer.sky, target=star, nearest=answer.direction)
    (folder / "feasible_sky.svg").write_text(f"{sky}\n", encoding="utf-8")
    mission = ROOT / "examples" / "missions" / "earth_observation" / "mission.toml"
    options = {"sun": "40 deg", "earth": "25 deg", "moon": "15 deg", "rate": "1 deg/s"}
    body_sky, _ = body_sky_chart(place(mission, heads=2, **options))
    style = "<style>text { font-size: 12px }</style><ellipse"
    body_sky = str(body_sky).replace("<ellipse", style, 1)
    (folder / "star_tracker_view.svg").write_text(f"{body_sky}\n", encoding="utf-8")
    for name, columns in charts.items():
        (folder / f"{name}.svg").write_text(image_of(columns), encoding="utf-8")
    with mpl.rc_context(STYLE):
        for name, figure in drawn.items():
            figure.savefig(folder / f"{name}.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
