from .gate import State as State
from .session import Session as Session
from .watcher import Watcher as Watcher
