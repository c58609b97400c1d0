"""Reference modules, written like a user's own: with only the public names of mjsim."""
