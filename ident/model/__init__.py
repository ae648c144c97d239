"""Linear platform (or oscillator) + effects = equation of motion and sensor, and the list of their parameters."""

from .. import runtime

runtime.configure()

from .build import build_model as build_model  # noqa: E402  (JAX is configured first)
from .build import make_effect as make_effect  # noqa: E402
from .build import open_words as open_words  # noqa: E402
from .build import told_of as told_of  # noqa: E402
from .linear import FREQUENCY as FREQUENCY  # noqa: E402
from .linear import GAIN as GAIN  # noqa: E402
from .linear import MASS as MASS  # noqa: E402
from .linear import QUALITY as QUALITY  # noqa: E402
from .linear import LinearPart as LinearPart  # noqa: E402
from .linear import linear_part as linear_part  # noqa: E402
from .model import ABOVE_THE_DRIVE as ABOVE_THE_DRIVE  # noqa: E402
from .model import COARSE as COARSE  # noqa: E402
from .model import Model as Model  # noqa: E402
from .parameters import ModelParameter as ModelParameter  # noqa: E402
from .settings import as_weighed_by as as_weighed_by  # noqa: E402
