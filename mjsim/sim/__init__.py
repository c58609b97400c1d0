"""The simulation: owns MuJoCo's model and state; drives, sensors, pictures and contact."""

from mjsim.sim.simulation import Simulation

__all__ = ["Simulation"]
