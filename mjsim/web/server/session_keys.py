"""Authentication: the user's token, one-time addresses, and browser sessions."""

import hmac
import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from hashlib import sha256

from mjsim.errors import UsageError

LIFETIME_SECONDS = 300.0
"""Validity of a one-time address [s]."""
MIN_TOKEN_LENGTH = 16
"""Minimum length of a user-defined token [characters]."""
MAX_SESSIONS, MAX_PASSES = 200, 100
"""Maximum numbers of sessions and passes; the oldest are dropped."""


@dataclass(frozen=True, slots=True, eq=False)
class Pass:
    """A word that admits one browser, once."""

    word: str
    ends: float
    """Expiry, on the monotonic clock [s]."""
    over: threading.Event = field(default_factory=threading.Event)
    """Set once it was used or revoked."""


class Keys:
    """Issues passes, exchanges them for sessions, and verifies sessions. Thread-safe.

    A session is bound to the peer that started it: cookies of an address go to all its ports, so a program of another
    user could receive one.
    """

    def __init__(self, token: str | None = None, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Start without sessions.

        Args:
            token: Accepted any number of times, in addition to passes; None accepts only passes.
            clock: Returns the time [s].

        Raises:
            UsageError: The token is short enough to be guessed.
        """
        if token is not None and len(token) < MIN_TOKEN_LENGTH:
            raise UsageError(
                f"the token has {len(token)} characters; use at least {MIN_TOKEN_LENGTH}, chosen at random"
            )
        self._token, self._clock = token, clock
        self._lock = threading.Lock()
        self._passes: OrderedDict[bytes, Pass] = OrderedDict()
        self._sessions: OrderedDict[bytes, str] = OrderedDict()

    def new_pass(self) -> Pass:
        """Return a pass of 256 bits that is valid for `LIFETIME_SECONDS`."""
        made = Pass(secrets.token_urlsafe(32), self._clock() + LIFETIME_SECONDS)
        with self._lock:
            self._passes[_digest(made.word)] = made
            if len(self._passes) > MAX_PASSES:
                self._passes.popitem(last=False)[1].over.set()
        return made

    def exchange(self, word: str, *, peer: str) -> str | None:
        """Return a new session for a valid pass, which is used up; None for any other word."""
        with self._lock:
            given = self._passes.pop(_digest(word), None)
            if given is None:
                return None
            given.over.set()
            return self._begin(peer) if self._clock() < given.ends else None

    def log_in(self, word: str, *, peer: str) -> str | None:
        """Return a new session for the token or a valid pass; None for any other word."""
        if self._token is not None and hmac.compare_digest(_digest(word), _digest(self._token)):
            with self._lock:
                return self._begin(peer)
        return self.exchange(word, peer=peer)

    def know(self, sessions: Iterable[str], *, peer: Callable[[], str]) -> bool:
        """Return whether a peer started one of these sessions; the peer is determined only if needed."""
        with self._lock:
            for digest in map(_digest, sessions):
                if self._sessions.get(digest) is not None and self._sessions[digest] == peer():
                    self._sessions.move_to_end(digest)
                    return True
        return False

    def _begin(self, peer: str) -> str:
        session = secrets.token_urlsafe(32)
        self._sessions[_digest(session)] = peer
        if len(self._sessions) > MAX_SESSIONS:
            self._sessions.popitem(last=False)
        return session


def _digest(word: str) -> bytes:
    """Return the digest under which a word is looked up, so that the time of the lookup depends on no secret."""
    return sha256(word.encode("utf-8", "surrogatepass")).digest()
