from .control_env import DmEnvironment as DmEnvironment
from .gym import GymEnvironment as GymEnvironment
from .step import Step as Step
from .task import Task as Task
from .vector import vector_environment as vector_environment
