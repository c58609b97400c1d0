"""The small things of rooms: each function draws a kind, in variants that depend on its random stream."""

import cv2
import numpy as np
from numpy.random import Generator
from style_drawing import Picture, Rgb, blank, box, clouds, framed, grained, lines_of_text, shade

COVERS = ((150, 48, 44), (42, 74, 120), (60, 104, 70), (210, 190, 140), (64, 56, 60), (196, 120, 52), (228, 226, 218))
"""Colours of books and folders, RGB."""
PALETTES = (
    ((150, 170, 190), (120, 130, 90), (110, 84, 60), (190, 160, 110)),
    ((222, 170, 120), (176, 110, 90), (96, 70, 84), (60, 54, 70)),
    ((200, 210, 214), (120, 150, 160), (70, 100, 120), (46, 66, 84)),
    ((226, 214, 180), (190, 170, 90), (130, 140, 60), (86, 96, 50)),
)
"""Colours of paintings from top to bottom, RGB."""


def sheet(rng: Generator) -> Picture:
    """Return a printed sheet of paper: a heading, text, sometimes a figure."""
    paper = blank(50, 70, shade(rng, (240, 238, 230), 0.02))
    box(paper, 6, 6, rng.uniform(18, 36), 4, (40, 40, 44))
    low = 16
    if rng.random() < 0.5:
        box(paper, 6, 15, 38, 20, shade(rng, COVERS[rng.integers(len(COVERS))], 0.1))
        low = 39
    lines_of_text(rng, paper, (6, low, 38, 62 - low), step=4, ink=(90, 90, 94))
    cv2.rectangle(paper, (0, 0), (49, 69), (205, 203, 196), 1)
    return paper


def noted(rng: Generator) -> Picture:
    """Return a board of cork with papers pinned to it."""
    board = grained(rng, blank(256, 192, (176, 134, 88)), 9.0)
    for column in range(4):
        for row in range(2):
            if rng.random() < 0.85:
                paper = sheet(rng)
                if rng.random() < 0.4:
                    paper = cv2.resize(paper, (46, 40))
                x, y = 14 + 58 * column + rng.integers(0, 8), 14 + 84 * row + rng.integers(0, 12)
                board[y : y + paper.shape[0], x : x + paper.shape[1]] = paper
                cv2.circle(board, (int(x + paper.shape[1] // 2), int(y + 4)), 2, shade(rng, (190, 40, 40), 0.3), -1)
    return framed(board, 5, (120, 88, 56))


def written(rng: Generator) -> Picture:
    """Return a whiteboard with writing, a diagram and its tray."""
    board = grained(rng, blank(300, 190, (238, 240, 240)), 1.2)
    inks = ((40, 60, 150), (170, 40, 40), (40, 40, 44), (40, 120, 70))
    for row in range(int(rng.integers(4, 7))):
        points = np.cumsum(rng.normal([2.6, 0], [1.2, 2.6], (int(rng.integers(20, 44)), 2)), axis=0)
        points[:, 1] = np.clip(points[:, 1] - points[:, 1].mean(), -5, 5)
        cv2.polylines(
            board,
            [(points + np.array([18, 24 + 22 * row])).astype(np.int32)],
            False,
            inks[rng.integers(4)],
            1,
            cv2.LINE_AA,
        )
    for x, y in rng.uniform([160, 30], [250, 120], (4, 2)).astype(int).tolist():
        cv2.rectangle(board, (x, y), (x + 34, y + 20), inks[rng.integers(4)], 1)
        cv2.arrowedLine(board, (x + 17, y + 20), (x + 10, y + 40), inks[2], 1, cv2.LINE_AA)
    return framed(board, 4, (160, 164, 168))


def books(rng: Generator) -> Picture:
    """Return the spines of a row of books, 0.8 m of them, all as high as the picture."""
    row, x = blank(256, 80, (40, 34, 30)), 0.0
    while x < 256:
        thick = rng.uniform(6, 17)
        color = shade(rng, COVERS[rng.integers(len(COVERS))], 0.2)
        box(row, x, 0, thick, 80, color)
        box(row, x, 0, 1, 80, shade(rng, (30, 26, 24), 0.1))
        title, light = rng.uniform(10, 30), sum(color) < 330
        ink = (226, 216, 180) if light else (54, 48, 44)
        box(row, x + thick * 0.3, title, max(thick * 0.4, 2), rng.uniform(16, 34), ink)
        for band in (6, 70):
            box(row, x + 1, band, thick - 1, 2, ink if rng.random() < 0.6 else color)
        x += thick
    return grained(rng, row, 3.0)


def folders(rng: Generator) -> Picture:
    """Return a row of ring binders with labels."""
    row = blank(256, 80, (44, 42, 42))
    for x in range(0, 256, 19):
        color = shade(rng, COVERS[rng.integers(len(COVERS))], 0.15)
        box(row, x, 0, 18, 80, color)
        box(row, x + 3, 10, 12, 30, (232, 230, 222))
        lines_of_text(rng, row, (x + 5, 13, 8, 24), step=5, ink=(70, 70, 74))
        cv2.circle(row, (x + 9, 62), 4, (30, 30, 32), -1)
        cv2.circle(row, (x + 9, 62), 4, (190, 192, 194), 1)
    return grained(rng, row, 2.0)


def screen(rng: Generator) -> Picture:
    """Return a monitor that shows windows with text and a chart."""
    glass = blank(144, 90, shade(rng, (38, 58, 84), 0.2))
    for x, y, width, height in ((8, 8, 74, 62), (70, 22, 66, 54)):
        box(glass, x, y, width, height, (228, 230, 234))
        box(glass, x, y, width, 6, (90, 110, 150))
        lines_of_text(rng, glass, (x + 4, y + 10, width - 8, height - 14), step=5, ink=(80, 84, 100))
    chart = np.column_stack([np.linspace(78, 130, 12), 62 - 20 * rng.random(12)]).astype(np.int32)
    cv2.polylines(glass, [chart], False, (200, 70, 50), 1, cv2.LINE_AA)
    return framed(glass, 4, (30, 30, 34))


def keyboard(rng: Generator) -> Picture:
    """Return a keyboard from above."""
    keys = blank(128, 44, (44, 45, 48))
    for row in range(5):
        for x in range(4, 122, 8):
            box(keys, x, 4 + 8 * row, 6, 6, shade(rng, (86, 88, 92), 0.08))
    return keys


def view(rng: Generator, *, town: bool) -> Picture:
    """Return the view from a window: sky, houses or trees, meadow or street."""
    width, height = 256, 200
    rise = np.linspace(0, 1, height)[:, None, None]
    sky = (1 - rise) * np.array([150, 184, 222]) + rise * np.array([226, 234, 240])
    light = 16.0 * np.clip(clouds(rng, width, height, 40), 0, 2)
    picture = np.clip(np.broadcast_to(sky, (height, width, 3)) + light[..., None], 0, 255).astype(np.uint8)
    (_houses if town else _trees)(rng, picture)
    ground = blank(width, 46, (120, 122, 124) if town else (104, 138, 78))
    picture[-46:] = grained(rng, ground, 7.0)
    return cv2.GaussianBlur(picture, (0, 0), 0.7)


def _houses(rng: Generator, picture: Picture) -> None:
    x = -10
    while x < picture.shape[1]:
        width, top = int(rng.uniform(36, 70)), int(rng.uniform(40, 100))
        color = shade(rng, ((196, 176, 150), (178, 112, 92), (200, 200, 196))[rng.integers(3)], 0.1)
        box(picture, x, top, width, 200 - top, color)
        roof = np.array([[x, top], [x + width // 2, top - 18], [x + width, top]], dtype=np.int32)
        cv2.fillPoly(picture, [roof], shade(rng, (120, 66, 54), 0.15))
        for row in range(top + 8, 150, 20):
            for column in range(x + 6, x + width - 8, 14):
                box(picture, column, row, 7, 11, shade(rng, (74, 86, 100), 0.25))
        x += width + int(rng.uniform(0, 12))


def _trees(rng: Generator, picture: Picture) -> None:
    for x in np.arange(0, 270, 30) + rng.normal(0, 8, 9):
        top = rng.uniform(60, 110)
        box(picture, x - 3, top + 30, 6, 100, (90, 68, 50))
        for dx, dy in rng.normal(0, [13, 17], (120, 2)):
            place = int(x + dx), int(top + 22 + dy)
            cv2.circle(picture, place, int(rng.uniform(2, 6)), shade(rng, (74, 112, 58), 0.25), -1)


def blinds(rng: Generator) -> Picture:
    """Return a Venetian blind, its slats lit from above."""
    slats = np.tile(np.array([222, 232, 228, 218, 196, 150]), 26)[:150]
    return grained(rng, np.broadcast_to(slats[:, None, None], (150, 128, 3)).astype(np.uint8), 2.0)


def curtain(rng: Generator) -> Picture:
    """Return a curtain in folds with a woven pattern."""
    folds = 0.85 + 0.15 * np.sin(np.cumsum(rng.uniform(0.2, 0.6, 96)))
    cloth = np.broadcast_to(folds[None, :, None] * np.array([176, 150, 120]), (190, 96, 3)).copy()
    cloth[6::16] *= 0.9
    cloth[:, ::9] *= 0.95
    return grained(rng, np.clip(cloth, 0, 255).astype(np.uint8), 4.0)


def leaf(rng: Generator, *, color: Rgb, panels: bool) -> Picture:
    """Return a door leaf, with wood grain, and with panels in a home."""
    door = grained(rng, blank(110, 250, color), 2.0)
    streaks = cv2.resize(rng.normal(0, 6.0, (4, 110)).astype(np.float32), (110, 250), interpolation=cv2.INTER_CUBIC)
    door = np.clip(door + streaks[..., None], 0, 255).astype(np.uint8)
    dark, lighter = shade(rng, tuple(int(c * 0.72) for c in color), 0.0), tuple(min(int(c * 1.12), 255) for c in color)
    for x, y, width, height in ((14, 16, 82, 90), (14, 128, 82, 104)) if panels else ((0, 222, 110, 24),):
        cv2.rectangle(door, (x, y), (x + width, y + height), dark, 2)
        cv2.rectangle(door, (x + 2, y + 2), (x + width - 2, y + height - 2), lighter, 1)
    cv2.rectangle(door, (0, 0), (109, 249), dark, 1)
    return door


def radiator(rng: Generator) -> Picture:
    """Return a radiator with its ribs, grille and valve."""
    ribs = 226 + 12 * np.sin(np.arange(220) * (2 * np.pi / 11)) - 46 * (np.arange(220) % 11 == 0)
    body = np.broadcast_to(ribs[None, :, None], (120, 220, 3)).astype(np.uint8).copy()
    box(body, 0, 0, 220, 9, (214, 214, 210))
    for x in range(4, 216, 6):
        box(body, x, 3, 3, 4, (120, 120, 118))
    box(body, 0, 112, 220, 8, (188, 188, 186))
    box(body, 206, 12, 12, 18, (240, 240, 238))
    return grained(rng, body, 1.5)


def socket(rng: Generator, *, count: int) -> Picture:
    """Return sockets side by side in a white frame."""
    plate = blank(48 * count, 48, (236, 236, 232))
    for n in range(count):
        middle = 24 + 48 * n, 24
        cv2.circle(plate, middle, 17, (198, 198, 194), -1, cv2.LINE_AA)
        cv2.circle(plate, middle, 17, (150, 150, 148), 1, cv2.LINE_AA)
        for dx in (-6, 6):
            cv2.circle(plate, (middle[0] + dx, 24), 2, (40, 40, 42), -1)
    return grained(rng, framed(plate, 2, (206, 206, 202)), 1.0)


def switch(rng: Generator) -> Picture:
    """Return a light switch."""
    plate = blank(48, 48, (238, 238, 234))
    box(plate, 10, 10, 28, 28, (226, 226, 222))
    cv2.rectangle(plate, (10, 10), (37, 37), (164, 164, 160), 1)
    cv2.line(plate, (11, 24), (36, 24), (190, 190, 186), 1)
    return grained(rng, framed(plate, 2, (206, 206, 202)), 1.0)


def duct(rng: Generator) -> Picture:
    """Return a piece of cable duct with sockets for power and data."""
    strip = grained(rng, blank(360, 36, (226, 227, 224)), 1.0)
    for x in (40, 70, 100, 240, 270):
        box(strip, x, 6, 24, 24, (240, 240, 238))
        cv2.circle(strip, (x + 12, 18), 8, (176, 176, 174), -1, cv2.LINE_AA)
        for dx in (-3, 3):
            cv2.circle(strip, (x + 12 + dx, 18), 1, (40, 40, 42), -1)
    for y in (0, 35):
        cv2.line(strip, (0, y), (360, y), (160, 160, 158), 1)
    cv2.line(strip, (180, 0), (180, 36), (180, 180, 178), 1)
    return strip


def door_sign(rng: Generator) -> Picture:
    """Return the sign beside a door: a room's number and names."""
    plate = blank(84, 60, (226, 228, 230))
    number = f"{rng.integers(1, 4)}.{rng.integers(1, 30):02d}"
    cv2.putText(plate, number, (6, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.62, (30, 50, 90), 2, cv2.LINE_AA)
    lines_of_text(rng, plate, (7, 34, 66, 24), step=8, ink=(60, 62, 66))
    return framed(plate, 1, (140, 142, 146))


def exit_sign(_: Generator) -> Picture:
    """Return the green sign over a way out."""
    sign = blank(120, 54, (26, 128, 74))
    cv2.putText(sign, "EXIT", (10, 38), cv2.FONT_HERSHEY_DUPLEX, 0.95, (240, 246, 240), 2, cv2.LINE_AA)
    cv2.arrowedLine(sign, (88, 27), (112, 27), (240, 246, 240), 3, cv2.LINE_AA, 0, 0.4)
    return framed(sign, 1, (220, 230, 222))


def notice(rng: Generator, *, color: Rgb, word: str) -> Picture:
    """Return a sign with a word and small print."""
    sign = blank(100, 76, (238, 238, 232))
    box(sign, 0, 0, 100, 30, color)
    cv2.putText(sign, word, (6, 22), cv2.FONT_HERSHEY_DUPLEX, 0.56, (245, 245, 240), 1, cv2.LINE_AA)
    lines_of_text(rng, sign, (8, 38, 82, 34), step=8, ink=(50, 50, 54))
    return framed(sign, 1, (90, 90, 92))


def clock(_: Generator) -> Picture:
    """Return a wall clock on a pale plate."""
    face = blank(96, 96, (222, 220, 214))
    cv2.circle(face, (48, 48), 45, (40, 40, 44), -1, cv2.LINE_AA)
    cv2.circle(face, (48, 48), 41, (244, 244, 240), -1, cv2.LINE_AA)
    for hour in range(12):
        c, s = np.cos(hour * np.pi / 6), np.sin(hour * np.pi / 6)
        cv2.line(face, (int(48 + 34 * c), int(48 + 34 * s)), (int(48 + 39 * c), int(48 + 39 * s)), (30, 30, 32), 2)
    cv2.line(face, (48, 48), (34, 32), (20, 20, 22), 3, cv2.LINE_AA)
    cv2.line(face, (48, 48), (72, 36), (20, 20, 22), 2, cv2.LINE_AA)
    return face


def painting(rng: Generator) -> Picture:
    """Return a landscape of broad strokes in a wide frame, unlike the flat shapes of posters."""
    picture = blank(160, 120, shade(rng, (150, 160, 170), 0.15))
    tones = PALETTES[rng.integers(len(PALETTES))]
    for _ in range(420):
        x, y = rng.integers(0, 160), rng.integers(0, 120)
        base = tones[int(np.clip(y / 30 + rng.normal(0, 0.5), 0, 3))]
        cv2.ellipse(
            picture,
            (int(x), int(y)),
            (int(rng.uniform(4, 16)), 2),
            rng.normal(0, 14),
            0,
            360,
            shade(rng, base, 0.2),
            -1,
        )
    cv2.rectangle(picture, (9, 9), (150, 110), (230, 226, 214), 7)
    return framed(picture, 7, shade(rng, (126, 92, 50), 0.2))


def panel_of_text(rng: Generator) -> Picture:
    """Return a panel as in museums: a heading and columns of text."""
    panel = blank(140, 190, shade(rng, (238, 236, 228), 0.01))
    box(panel, 12, 14, rng.uniform(60, 110), 9, (50, 46, 44))
    lines_of_text(rng, panel, (12, 36, 54, 140), step=6, ink=(96, 92, 90))
    lines_of_text(rng, panel, (74, 36, 54, 140), step=6, ink=(96, 92, 90))
    return framed(panel, 1, (196, 194, 186))


def label(rng: Generator) -> Picture:
    """Return the small label beside a picture in a museum."""
    card = blank(60, 44, (242, 241, 236))
    lines_of_text(rng, card, (6, 8, 46, 30), step=8, ink=(60, 58, 56))
    return framed(card, 1, (190, 188, 180))


def vent(_: Generator) -> Picture:
    """Return a ventilation grille."""
    grille = blank(100, 60, (206, 206, 202))
    for y in range(7, 54, 6):
        box(grille, 8, y, 84, 3, (82, 82, 82))
    return framed(grille, 3, (222, 222, 218))


def carton(rng: Generator) -> Picture:
    """Return the side of a carton: flutes, tape, a label and the arrows that say which side is up."""
    side = grained(rng, blank(160, 130, shade(rng, (182, 142, 96), 0.06)), 4.0)
    box(side, 0, 58, 160, 13, (198, 164, 118))
    x, y = rng.integers(8, 90), rng.integers(74, 84)
    box(side, x, y, 52, 38, (238, 236, 228))
    lines_of_text(rng, side, (x + 4, y + 4, 44, 16), step=6, ink=(40, 40, 42))
    for bar in range(0, 42, 3):
        box(side, x + 4 + bar, y + 24, rng.integers(1, 3), 11, (30, 30, 32))
    for dx in (0, 14):
        cv2.arrowedLine(side, (int(124 + dx), 48), (int(124 + dx), 16), (70, 50, 36), 3, cv2.LINE_AA, 0, 0.4)
    cv2.rectangle(side, (0, 0), (159, 129), (140, 106, 68), 2)
    return side


def hazard(rng: Generator) -> Picture:
    """Return a band of yellow and black stripes."""
    y, x = np.mgrid[:24, :192]
    stripes = np.where((((x + y) // 16) % 2 == 0)[..., None], (226, 184, 44), (44, 42, 40))
    return grained(rng, stripes.astype(np.uint8), 5.0)


def extinguisher(rng: Generator) -> Picture:
    """Return a fire extinguisher before a red plate."""
    plate = blank(60, 130, (206, 206, 200))
    cv2.ellipse(plate, (30, 40), (15, 12), 0, 180, 360, (168, 30, 28), -1, cv2.LINE_AA)
    box(plate, 15, 40, 31, 82, (176, 32, 30))
    box(plate, 19, 40, 5, 82, (214, 84, 78))
    box(plate, 20, 62, 22, 30, (236, 232, 224))
    lines_of_text(rng, plate, (22, 65, 18, 24), step=5, ink=(60, 60, 60))
    box(plate, 24, 12, 12, 18, (40, 40, 42))
    cv2.polylines(
        plate, [np.array([[36, 18], [50, 30], [50, 84]], dtype=np.int32)], False, (36, 36, 38), 3, cv2.LINE_AA
    )
    return plate


def lamp(rng: Generator) -> Picture:
    """Return a square lamp with a louvre, seen from below."""
    light = blank(120, 120, (255, 255, 250))
    for k in range(0, 120, 20):
        box(light, k, 0, 2, 120, (214, 216, 216))
        box(light, 0, k, 120, 2, (222, 224, 224))
    return framed(light, 3, (204, 206, 206))


def skirting(rng: Generator, *, color: Rgb) -> Picture:
    """Return a metre of skirting board: a rounded top, a joint, marks of shoes."""
    board = grained(rng, blank(256, 20, color), 2.5)
    board[:3] = np.clip(board[:3] * 1.12, 0, 255)
    board[3] = board[3] * 0.8
    for x in rng.integers(0, 250, 7):
        cv2.line(
            board,
            (int(x), int(rng.integers(8, 18))),
            (int(x + rng.integers(2, 14)), 14),
            shade(rng, (70, 66, 62), 0.2),
            1,
        )
    board[:, :1] = board[:, :1] * 0.6
    return board
