# SPDX-License-Identifier: BSD-3-Clause
"""The model of a problem as the user declares it: validated and immutable.

All names here are public: the package offers them as its own (`tilth.Box`).
"""

from tilth.model.bodies import Body as Body
from tilth.model.boundaries import AffineBoundary as AffineBoundary
from tilth.model.boundaries import NodeBoundary as NodeBoundary
from tilth.model.boundaries import PlaneBoundary as PlaneBoundary
from tilth.model.cam_clay import ModifiedCamClay as ModifiedCamClay
from tilth.model.geometry import BoxGeometry as BoxGeometry
from tilth.model.geometry import CircleGeometry as CircleGeometry
from tilth.model.geometry import CylinderGeometry as CylinderGeometry
from tilth.model.geometry import FootingGeometry as FootingGeometry
from tilth.model.geometry import FunctionGeometry as FunctionGeometry
from tilth.model.geometry import PlaneGeometry as PlaneGeometry
from tilth.model.geometry import PolylineGeometry as PolylineGeometry
from tilth.model.geometry import SphereGeometry as SphereGeometry
from tilth.model.geometry import SplineGeometry as SplineGeometry
from tilth.model.geometry import StlGeometry as StlGeometry
from tilth.model.implicit import ImplicitBoundary as ImplicitBoundary
from tilth.model.implicit import Rotation as Rotation
from tilth.model.initial import AtRest as AtRest
from tilth.model.initial import GivenStress as GivenStress
from tilth.model.initial import Initial as Initial
from tilth.model.loads import BodyForce as BodyForce
from tilth.model.loads import PointForce as PointForce
from tilth.model.materials import HenckyElastic as HenckyElastic
from tilth.model.materials import VonMises as VonMises
from tilth.model.model import Model as Model
from tilth.model.schedule import Schedule as Schedule
from tilth.model.settings import Analysis as Analysis
from tilth.model.settings import Follow as Follow
from tilth.model.settings import Grid as Grid
from tilth.model.settings import Limits as Limits
from tilth.model.settings import Output as Output
from tilth.model.settings import Units as Units
from tilth.model.shapes import Box as Box
from tilth.model.shapes import Circle as Circle
from tilth.model.shapes import Cylinder as Cylinder
from tilth.model.shapes import Mesh as Mesh
from tilth.model.shapes import Polygon as Polygon
from tilth.model.shapes import Sphere as Sphere
from tilth.model.soils import DruckerPrager as DruckerPrager
from tilth.model.soils import MohrCoulomb as MohrCoulomb
from tilth.model.soils import Tresca as Tresca
from tilth.model.surface import Hydrostatic as Hydrostatic
from tilth.model.surface import Surface as Surface
from tilth.model.surface import SurfaceLoad as SurfaceLoad
from tilth.model.track import Track as Track
from tilth.model.user_laws import StateVariable as StateVariable
from tilth.model.user_laws import UserCompiled as UserCompiled
from tilth.model.user_laws import UserPython as UserPython
from tilth.model.user_laws import UserUmat as UserUmat
