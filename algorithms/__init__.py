"""Reference modules, written as a user would write his own: on the public names of mjsim alone."""
