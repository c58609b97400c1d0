"""Derives the role of drawing elements from the names of their layers and blocks."""

import re
import unicodedata
from functools import lru_cache
from typing import Literal

Role = Literal["wall", "door", "window", "opening", "furniture", "column", "stairs", "room", "note"]
"""An opening is a door or a window. Notes are annotations, not parts of the building."""

_TEXT: dict[Role, str] = {
    "note": """
        text txt dim dims dimension dimensions anno annot annotation bemassung mass masse cote cotes cotation cota
        cotas quote hatch hatching pattern schraffur hachure hachures grid axis axes achse achsen raster titel title
        titleblock border frame rahmen cadre viewport vport vports defpoints legend legende symbol symb north nord
        scale scalebar massstab label labels note notes notiz ceiling clng
        ceil light lights lighting elec electrical electric lamp hvac mech pipe piping revision rev logo sheet image
        xref construction hilfslinie hilfslinien guide guides roof dach slab beschriftung background robot
        robots beacon beacons lamps""",
    "room": "room rooms raum raeume space spaces zone area areas sala salas stanza stanze rum",
    "stairs": "stair stairs strs treppe treppen escalier escaliers escalera scala step steps ramp",
    "window": """
        window windows glaz glazing glass fenster fenetre fenetres ventana ventanas finestra finestre janela janelas
        raam ramen win okno okna foenster vindu vinduer vindue ikkuna ikkunat pencere""",
    "door": """door doors tuer tuere tueren tur turen porte portes puerta puertas porta portas deur deuren drzwi dvere
        doerr doerrar doer doere dor dorer ovi ovet kapi""",
    "opening": "opening openings oeffnung oeffnungen ouverture ouvertures abertura aberturas apertura aperture",
    "column": "column columns cols col pillar pillars stuetze stuetzen saeule poteau poteaux columna pilastro",
    "furniture": """furniture furn furnishing furnishings moebel mobel einrichtung inventar mobilier meuble meubles
        mobiliario mueble arredo mobili desk desks table tables tisch tische chair chairs stuhl stuehle sofa couch bed
        beds bett cabinet cabinets shelf shelves regal schrank wardrobe sink toilet wc bath bathtub shower sanitary
        sanitaer plumbing plumb fixture fixtures flor equipment equip eqpm appliance appliances kitchen kueche casework
        cwmg lounge bench counter fridge stove cooker oven basin armchair bookcase piano tv plant plants thing
        things obstacle obstacles""",
    "wall": """wall walls wand waende wande mauer mauern mauerwerk mur murs muro muros muri pared paredes parete pareti
        tabique tabiques cloison cloisons partition partitions trennwand aussenwand innenwand vegg vegger vaegg
        vaeggar vaegge seina seinat muur muren sciana sciany stena steny zdivo duvar""",
}
WORDS = {role: frozenset(text.split()) for role, text in _TEXT.items()}
"""Words for each role, in the languages of most drawings; the first role with a matching word applies."""
_LATIN = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "å": "a", "ø": "o", "æ": "ae", "ł": "l"})


def role_of(*names: str) -> Role | None:
    """Return the role given by the names of layers or blocks, the first name that gives one; None if none does."""
    return next((role for name in names if (role := _role_of(name))), None)


@lru_cache(maxsize=4096)  # a drawing has few names, and thousands of lines under each
def _role_of(name: str) -> Role | None:
    words = _words(name)
    joined = "".join(words)
    roles = {role for role, known in WORDS.items() if not known.isdisjoint(words)}
    roles |= {role for role in _COMPOUND if any(word in joined for word in _COMPOUND[role])} if not roles else set()
    if {"door", "window"} <= roles:
        return "opening"
    return next((role for role in WORDS if role in roles), None)


_COMPOUND: dict[Role, tuple[str, ...]] = {
    "door": ("door", "tuer", "puerta", "двер", "门", "門", "ドア", "扉"),
    "window": ("window", "fenster", "ventana", "окн", "窗", "窓"),
    "furniture": ("furnit", "moebel", "mobilier", "мебел", "家具"),
    "stairs": ("stair", "treppe", "escalier", "лестн", "楼梯", "階段"),
    "column": ("колонн", "柱"),
    "wall": ("wall", "wand", "mauer", "waende", "стен", "墙", "牆", "壁"),
}
"""Fragments of compound words that contain a role: 'Innenwand24', 'doorblock'."""


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case, without accents: 'A-WALL-Ext2' gives a, wall, ext."""
    split = re.sub(r"([a-zäöüß])([A-Z])", r"\1 \2", name)
    plain = unicodedata.normalize("NFC", split).lower().translate(_LATIN)
    bare = "".join(sign for sign in unicodedata.normalize("NFD", plain) if not unicodedata.combining(sign))
    return [word for word in re.split(r"[\W\d_]+", bare) if word]
