"""Draw docs/images/architecture.svg, the parts of mjsim and what they import, and fill a table of docs/architecture.md.

python scripts/make/architecture_picture.py

A part is drawn above all parts that it imports. Redundant arrows are left out: where A imports B and B imports C, there
is none from A to C. The table has all imports.
"""

from collections.abc import Mapping
from graphlib import TopologicalSorter
from pathlib import Path

import matplotlib

import mjsim
from mjsim.bench.import_graph import Package

ROOT = Path(__file__).resolve().parents[2]
PAGE, PICTURE = ROOT / "docs" / "architecture.md", ROOT / "docs" / "images" / "architecture.svg"
BEGIN, END = "<!-- imports: begin -->\n", "<!-- imports: end -->\n"
GROUND = {
    *("closing", "errors", "faces", "geometry", "gl_request", "guarded", "inventory", "output", "progress"),
    *("sentences", "spelling", "syntax", "traces", "views"),
}
"""Parts that all others may import, drawn as one box."""
LEFT_OUT = {"bench", "doctor"}
INK, PAPER, LINE = "#1d2a33", "#eef3f6", "#6c8796"
Graph = Mapping[str, set[str]]


def parts_and_imports(package: Package) -> dict[str, set[str]]:
    """Return what each part imports of the other parts; the ground is one part."""
    graph = dict[str, set[str]]()
    for importer, modules in package.module_graph.items():
        one = _part(package, importer)
        for module in modules:
            other = _part(package, module)
            if one and other and one != other and one not in LEFT_OUT and other not in LEFT_OUT:
                graph.setdefault(one, set()).add(other)
                graph.setdefault(other, set())
    return graph


def _part(package: Package, module: str) -> str | None:
    part = package.part(module)
    return "ground" if part in GROUND else part


def levels(graph: Graph) -> dict[str, int]:
    """Return the length of the longest chain of imports from each part to the ground."""
    found: dict[str, int] = {}
    for part in TopologicalSorter(graph).static_order():
        found[part] = max((found[below] + 1 for below in graph[part]), default=0)
    return found


def essential(graph: Graph) -> dict[str, set[str]]:
    """Return the imports that no chain through other parts implies."""
    reached: dict[str, set[str]] = {}
    for part in TopologicalSorter(graph).static_order():
        reached[part] = graph[part].union(*(reached[below] for below in graph[part]))
    return {
        part: {low for low in lows if not any(low in reached[other] for other in lows)} for part, lows in graph.items()
    }


def table(graph: Graph) -> str:
    """Return the parts and their imports as a table, from the top to the ground."""
    height = levels(graph)
    rows = [
        f"| `{part}` | {', '.join(f'`{low}`' for low in sorted(graph[part])) or 'nothing'} |"
        for part in sorted(graph, key=lambda part: (-height[part], part))
    ]
    return "\n".join(["| part | imports |", "|---|---|", *rows, ""])


def places(graph: Graph) -> dict[str, tuple[float, float]]:
    """Return where the middle of each part's box is: one row per level, ordered so that arrows are short."""
    height, found = levels(graph), dict[str, tuple[float, float]]()
    for level in range(max(height.values()) + 1):
        row = [part for part in graph if height[part] == level]
        above = {part: [found[low][0] for low in graph[part] if low != "ground"] for part in row}
        row.sort(key=lambda part: (sum(above[part]) / len(above[part]) if above[part] else 0.0, part))
        found |= {part: (number - (len(row) - 1) / 2, float(level)) for number, part in enumerate(row)}
    return found


def draw(graph: Graph, path: Path) -> None:
    """Draw the parts and the arrows between them."""
    matplotlib.use("Agg")
    matplotlib.rcParams |= {"svg.hashsalt": "mjsim", "svg.fonttype": "none", "font.family": "sans-serif"}
    from matplotlib import pyplot

    spots = {part: (1.9 * x, 1.25 * y) for part, (x, y) in places(graph).items()}
    figure, axes = pyplot.subplots(figsize=(11, 11))
    for part, lows in sorted(essential(graph).items()):
        for low in sorted(lows):
            (x, y), (u, v) = spots[part], spots[low]
            way = {"arrowstyle": "-|>", "color": LINE, "lw": 1.0, "shrinkA": 0, "shrinkB": 2}
            axes.annotate("", xy=(u, v + 0.27), xytext=(x, y - 0.27), arrowprops=way)
    box = {"boxstyle": "round,pad=0.45", "facecolor": PAPER, "edgecolor": INK, "lw": 1.2}
    for part, (x, y) in sorted(spots.items()):
        axes.text(x, y, part, ha="center", va="center", color=INK, fontsize=12, bbox=box)
    axes.set_xlim(min(x for x, _ in spots.values()) - 1.2, max(x for x, _ in spots.values()) + 1.2)
    axes.set_ylim(-0.6, max(y for _, y in spots.values()) + 0.6)
    axes.axis("off")
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})
    pyplot.close(figure)


def with_table(page: str, text: str) -> str:
    """Return the page with another table between its marks."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{text}\n{END}{after}"


def main() -> None:
    """Write the picture, and the table into the page."""
    graph = parts_and_imports(Package(Path(mjsim.__file__).parent))
    draw(graph, PICTURE)
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), table(graph)), encoding="utf-8")
    print(PICTURE, PAGE, sep="\n")


if __name__ == "__main__":
    main()
