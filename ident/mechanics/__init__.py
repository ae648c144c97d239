"""The physics as pure functions: section, residual stress, stiffness under axial force, its three closures, hysteresis.

Everything is SI, jit-, vmap- and differentiable, and knows nothing of files, parameters or records.
"""

from .axial import AxialForce as AxialForce
from .axial import SignChange as SignChange
from .axial import arch_force as arch_force
from .axial import axial_force as axial_force
from .axial import axial_forces as axial_forces
from .axial import shortening as shortening
from .axial import sign_change as sign_change
from .frame import FrameLaw as FrameLaw
from .frame import InPlane as InPlane
from .frame import end_stiffness as end_stiffness
from .frame import frame_law as frame_law
from .hysteresis import drive_force_coefficient as drive_force_coefficient
from .hysteresis import polynomial_strain as polynomial_strain
from .l_frame import in_plane_flexibility as in_plane_flexibility
from .l_frame import shortening_stiffness as shortening_stiffness
from .residual import InitialShape as InitialShape
from .residual import Moment as Moment
from .residual import initial_shape as initial_shape
from .residual import mean_force as mean_force
from .residual import residual_moment as residual_moment
from .restoring import Closure as Closure
from .restoring import Restoring as Restoring
from .restoring import restoring as restoring
from .restoring import restoring_force as restoring_force
from .restoring import restoring_stiffness as restoring_stiffness
from .scalar import Scalar as Scalar
from .section import Section as Section
from .section import section as section
from .section import torsion_constant as torsion_constant
from .stage import BEAMS as BEAMS
from .stage import Beam as Beam
from .stage import l_beam as l_beam
from .stage import series_stiffness as series_stiffness
from .stage import stage_stiffness as stage_stiffness
from .stiffness import segment_stiffness as segment_stiffness
