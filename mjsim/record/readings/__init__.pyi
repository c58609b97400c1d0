from .codec import Box as Box
from .codec import DrawnTopic as DrawnTopic
from .codec import SensorTable as SensorTable
from .codecs import CODECS as CODECS
from .codecs import codec_of as codec_of
from .sightings import SIGHTINGS as SIGHTINGS
from .sightings import identities_of as identities_of
