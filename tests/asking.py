"""Requests of a client of the studio."""

ROOM = "mjsim: 1\nname: room\n"


def told(client, address, *, status=200, **keys):
    """Return the JSON of an answer to a POST, which has this status."""
    answer = client.post(f"/api/{address}", json=keys)
    assert answer.status_code == status, answer.text
    return answer.json()
