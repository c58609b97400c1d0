"""Four more motifs, so that a museum of forty pictures shows none twice."""

from poster_shapes import Layer, arc, bar, disc, oval, pie, poly, star

MUSEUM: dict[str, list[Layer]] = {
    "bell": [
        ("dark", arc(0, -0.38, 0.07, 0, 360, 0.05)),
        ("main", oval(0, -0.08, 0.24, 0.26)),
        ("main", poly((-0.24, -0.08), (0.24, -0.08), (0.4, 0.28), (-0.4, 0.28))),
        ("light", oval(-0.1, -0.06, 0.05, 0.16, 10)),
        ("accent", bar(-0.44, 0.29, 0.44, 0.29, 0.09)),
        ("dark", disc(0, 0.4, 0.08)),
    ],
    "clover": [
        ("dark", bar(0, 0.06, 0.14, 0.48, 0.06)),
        *(("main", disc(x, y, 0.19)) for x, y in ((-0.2, -0.2), (0.2, -0.2), (-0.2, 0.14), (0.2, 0.14))),
        *(("light", disc(x, y, 0.08)) for x, y in ((-0.22, -0.22), (0.22, -0.22), (-0.22, 0.16), (0.22, 0.16))),
        ("accent", star(0, -0.03, 4, 0.16, 0.06, 45)),
    ],
    "tent": [
        ("main", poly((0, -0.42), (0.48, 0.36), (-0.48, 0.36))),
        ("accent", poly((0, -0.42), (-0.2, 0.36), (-0.48, 0.36))),
        ("dark", poly((0.02, -0.2), (0.18, 0.36), (-0.08, 0.36))),
        ("dark", bar(0, -0.48, 0, -0.36, 0.03)),
        ("light", poly((0.0, -0.48), (0.16, -0.43), (0.0, -0.38))),
        ("light", bar(-0.5, 0.4, 0.5, 0.4, 0.07)),
    ],
    "ice": [
        ("accent", poly((-0.22, 0.02), (0.22, 0.02), (0, 0.48))),
        ("dark", bar(-0.14, 0.08, 0.06, 0.34, 0.025)),
        ("dark", bar(0.14, 0.08, -0.06, 0.34, 0.025)),
        ("light", pie(0, 0.02, 0.27, 180, 360)),
        ("main", disc(-0.12, -0.18, 0.17)),
        ("light", disc(0.14, -0.2, 0.15)),
        ("main", disc(0.02, -0.36, 0.12)),
        ("dark", disc(0.04, -0.45, 0.04)),
    ],
}
"""Motif by name, as in `poster_motifs`."""
