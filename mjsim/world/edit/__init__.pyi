from .changes import Change as Change
from .changes import edit_text as edit_text
from .changes import edited as edited
from .edited_text import UnwritableError as UnwritableError
from .formatter import format_file as format_file
from .layout import escaped as escaped
from .snippet import rounded as rounded
from .writer import format_world as format_world
