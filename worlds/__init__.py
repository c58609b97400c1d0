"""World files that come with mjsim; each one runs."""
