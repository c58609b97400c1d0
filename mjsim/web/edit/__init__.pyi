from .edit_api import EditApi as EditApi
from .panel_schema import schema_text as schema_text
from .preview import PICTURE_TIMEOUT as PICTURE_TIMEOUT
