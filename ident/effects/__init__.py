"""Physical effects: the abstraction, the library (one file each), and the user's own."""

from .effect import AbstractEffect as AbstractEffect
from .effect import Drive as Drive
from .effect import Parameter as Parameter
from .effect import State as State
from .effect import amplitude as amplitude
from .effect import choice as choice
from .effect import shape as shape
