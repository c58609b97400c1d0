from .bridge import WATCHDOG as WATCHDOG
from .bridge import Bridge as Bridge
from .bus import Bus as Bus
from .bus import domain_id as domain_id
from .private import bring_loopback_up as bring_loopback_up
from .private import enter_private_network as enter_private_network
from .services import call_name as call_name
