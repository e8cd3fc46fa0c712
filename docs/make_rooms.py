"""Draw the rooms and their imports, from the code: python docs/make_rooms.py.

Writes docs/images/rooms.svg and prints the counts that docs/layout.md quotes. Needs grimp, which
import-linter brings. The counts work for older versions too: PYTHONPATH=CHECKOUT/src.
"""

from collections import Counter
from pathlib import Path

import grimp
import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

PACKAGE = "gyrostat"
IMAGE = Path(__file__).parent / "images" / "rooms.svg"
BOX, ARROW = "#dbe7f4", "#5b6470"


def imports() -> tuple[dict[str, int], Counter[tuple[str, str]]]:
    """Modules of each room, and imports from one room to another."""
    graph = grimp.build_graph(PACKAGE)
    modules = Counter(_room(name) for name in graph.modules if name != PACKAGE)
    pairs: Counter[tuple[str, str]] = Counter()
    for name in graph.modules - {PACKAGE}:
        for used in graph.find_modules_directly_imported_by(name) - {PACKAGE}:
            if _room(name) != _room(used):
                pairs[_room(name), _room(used)] += 1
    return dict(modules), pairs


def _room(module: str) -> str:
    return module.split(".")[1]


def levels(rooms, pairs) -> dict[str, int]:
    """Level of each room: one above the highest room that it imports."""
    found: dict[str, int] = {}

    def level(room: str) -> int:
        if room not in found:
            used = [level(other) for one, other in pairs if one == room]
            found[room] = 1 + max(used, default=-1)
        return found[room]

    for room in rooms:
        level(room)
    return found


def direct(pairs) -> list[tuple[str, str]]:
    """Imports that no longer chain implies: enough to show what each room may use."""
    used: dict[str, set[str]] = {}
    for one, other in pairs:
        used.setdefault(one, set()).add(other)

    def reached(room: str) -> set[str]:
        return set().union(*({other} | reached(other) for other in used.get(room, set())))

    return [
        (one, other)
        for one, others in used.items()
        for other in others
        if not any(other in reached(between) for between in others - {other})
    ]


def drawn(rooms: dict[str, int], pairs) -> Figure:
    """Picture of the rooms by level, with arrows from a room to those that it uses."""
    level = levels(rooms, pairs)
    arrows = direct(pairs)
    place: dict[str, tuple[float, float]] = {}
    for height in range(max(level.values()), -1, -1):
        # each room below the middle of those that use it
        above = {
            room: [place[one][0] for one, other in arrows if other == room] or [0.5]
            for room in sorted(rooms)
            if level[room] == height
        }
        row = sorted(above, key=lambda room: sum(above[room]) / len(above[room]))
        place |= {room: ((k + 0.5) / len(row), float(height)) for k, room in enumerate(row)}
    figure = Figure(figsize=(6.0, 0.9 * (1 + max(level.values()))))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 1.0), ylim=(-0.5, max(level.values()) + 0.5))
    axes.axis("off")
    for one, other in arrows:
        (x, y), (to_x, to_y) = place[one], place[other]
        bend = 0.0 if y - to_y < 2.0 else 0.2 * (1 if x < 0.5 else -1)
        axes.add_patch(
            FancyArrowPatch(
                (x, y - 0.2),
                (to_x, to_y + 0.25),
                arrowstyle="-|>",
                mutation_scale=11,
                shrinkA=0,
                shrinkB=0,
                connectionstyle=f"arc3,rad={bend}",
                color=ARROW,
                lw=1.0,
            )
        )
    for room, (x, y) in place.items():
        axes.text(
            *(x, y, f"{room}\n{rooms[room]} modules"),
            ha="center",
            va="center",
            fontsize=10,
            linespacing=1.2,
            bbox={"boxstyle": "round,pad=0.35", "facecolor": BOX, "edgecolor": ARROW},
        )
    return figure


def main() -> None:
    """Draw the picture and print the counts."""
    rooms, pairs = imports()
    print(
        f"{len(rooms)} rooms, {sum(rooms.values())} modules, {len(pairs)} pairs of rooms with "
        f"imports, {sum(pairs.values())} imports between rooms, "
        f"{1 + max(levels(rooms, pairs).values())} levels"
    )
    with mpl.rc_context({"svg.fonttype": "path", "svg.hashsalt": PACKAGE}):
        drawn(rooms, pairs).savefig(IMAGE, metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
