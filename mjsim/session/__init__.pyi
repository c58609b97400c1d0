from .gate import State as State
from .session import Session as Session
from .touches import event_keys as event_keys
from .touches import keep_events as keep_events
from .watcher import Watcher as Watcher
