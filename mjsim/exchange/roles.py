"""What the names of layers and blocks of drawings say about what is on them."""

import re
from collections.abc import Iterable
from typing import Literal

Role = Literal["wall", "door", "window", "furniture", "column", "stairs", "note"]
"""Notes are what tells about the building and is no part of it."""

_TEXT: dict[Role, str] = {
    "note": """
        text txt dim dims dimension dimensions anno annot annotation bemassung mass masse cote cotes cotation cota
        cotas quote hatch hatching pattern schraffur hachure hachures grid axis axes achse achsen raster titel title
        titleblock border frame rahmen cadre viewport vport vports defpoints legend legende symbol symb north nord
        scale scalebar massstab label labels room rooms raum raeume zone area areas note notes notiz ceiling clng
        ceil light lights lighting elec electrical electric lamp hvac mech pipe piping revision rev logo sheet image
        xref construction hilfslinie hilfslinien guide guides roof dach slab beschriftung background robot
        robots beacon beacons lamps""",
    "stairs": "stair stairs strs treppe treppen escalier escaliers escalera scala step steps ramp",
    "window": "window windows glaz glazing glass fenster fenetre fenetres ventana ventanas finestra raam win",
    "door": """door doors tuer tuere tueren tur turen porte portes puerta puertas porta deur deuren drzwi opening
        openings oeffnung oeffnungen""",
    "column": "column columns cols col pillar pillars stuetze stuetzen saeule poteau poteaux columna pilastro",
    "furniture": """furniture furn furnishing furnishings moebel mobel einrichtung inventar mobilier meuble meubles
        mobiliario mueble arredo mobili desk desks table tables tisch tische chair chairs stuhl stuehle sofa couch bed
        beds bett cabinet cabinets shelf shelves regal schrank wardrobe sink toilet wc bath bathtub shower sanitary
        sanitaer plumbing plumb fixture fixtures flor equipment equip eqpm appliance appliances kitchen kueche casework
        cwmg lounge bench counter fridge stove cooker oven basin armchair bookcase piano tv plant plants thing
        things obstacle obstacles""",
    "wall": """wall walls wand waende wande mauer mauern mauerwerk mur murs muro muros muri pared paredes parete pareti
        tabique cloison cloisons partition partitions trennwand aussenwand innenwand vegg vaegg seina muur muren sciana
        sciany""",
}
WORDS = {role: frozenset(text.split()) for role, text in _TEXT.items()}
"""Words of a role, in the languages of most drawings; the first role that has a word of a name is taken."""
_LATIN = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "é": "e", "è": "e", "ê": "e", "ń": "n", "ś": "s"})


def role_of(*names: str) -> Role | None:
    """Return the role of what is on a layer or in a block; None when no name says it; the first that does counts."""
    for name in names:
        words = set(_words(name))
        for role, known in WORDS.items():
            if words & known:
                return role
        joined = "".join(_words(name))
        if found := next((role for role in _COMPOUND if any(word in joined for word in _COMPOUND[role])), None):
            return found
    return None


_COMPOUND: dict[Role, tuple[str, ...]] = {
    "door": ("door", "tuer", "puerta"),
    "window": ("window", "fenster", "ventana"),
    "furniture": ("furnit", "moebel", "mobilier"),
    "stairs": ("stair", "treppe", "escalier"),
    "wall": ("wall", "wand", "mauer", "waende"),
}
"""Parts of words that say it in one word with others: 'Innenwand24', 'doorblock'."""


def _words(name: str) -> Iterable[str]:
    """Return the words of a name in lower case, without accents: 'A-WALL-Ext2' has a, wall, ext."""
    split = re.sub(r"([a-zäöüß])([A-Z])", r"\1 \2", name)
    return [word for word in re.split(r"[^a-z]+", split.lower().translate(_LATIN)) if word]
