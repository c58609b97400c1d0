"""Pages for unauthenticated clients: the form for the token, and the step from a one-time address to the page."""

from html import escape

from mjsim.web.server.local import HEADERS

WELCOME_HEADERS = {
    **HEADERS,
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:; form-action 'self'; "
    "base-uri 'none'; frame-ancestors 'none'",
}
"""These pages run no scripts, and send their form only to their own server."""
# Without a referrer browsers send forms with the origin "null".
LOGIN_HEADERS = {**WELCOME_HEADERS, "Referrer-Policy": "strict-origin"}
_FRAME = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>mjsim</title>
{refresh}<style>
  body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 36em; margin: 12vh auto; padding: 0 1em }}
  input, button {{ font: inherit; padding: .3em .6em }}
  code {{ font-size: .9em }}
</style>
{body}
</html>
"""
_LOGIN = """<h1>mjsim</h1>
<p role="alert">{said}</p>
<form method="post" action="/login">
  <label>Token or one-time address<br>
  <input name="token" type="password" autocomplete="off" size="40" autofocus></label>
  <button>Open</button>
</form>
<p>This page can run programs as the person who started it, so it lets in only browsers that it knows. To get a
one-time address:</p>
<ul>
  <li>in a browser that is in already, choose <b>Open in another browser</b>;</li>
  <li>or send the process the signal that it named when it started: <code>kill -USR1 NUMBER</code> prints one.</li>
</ul>
"""


def login_page(message: str, *, again: bool = False) -> str:
    """Return the page that asks for the token.

    Args:
        message: Error of the previous attempt.
        again: Whether to reload the page at once, so that the request comes from this page and not from another.
    """
    return _framed(_LOGIN.format(said=escape(message)), again)


def welcome_page() -> str:
    """Return the page that leads to the studio."""
    return _framed('<p><a href="/">Opening the page …</a></p>', True)


def _framed(body: str, refresh: bool) -> str:
    return _FRAME.format(body=body, refresh='<meta http-equiv="refresh" content="0; url=/">\n' if refresh else "")
