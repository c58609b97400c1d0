"""Pictures, floor textures and robot presets that come with mjsim."""
