from amorsim.noise.aim_gaussian import AimGaussian
from amorsim.noise.angle_random_walk import AngleRandomWalk
from amorsim.noise.beam_model import BeamModel
from amorsim.noise.bias import Bias
from amorsim.noise.bias_instability import BiasInstability
from amorsim.noise.bias_random_walk import BiasRandomWalk
from amorsim.noise.bump import Bump
from amorsim.noise.compass_deviation import CompassDeviation
from amorsim.noise.cross_talk import CrossTalk
from amorsim.noise.diffusion import Diffusion
from amorsim.noise.dropout import Dropout
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.latency_jitter import LatencyJitter
from amorsim.noise.missed import Missed
from amorsim.noise.motion_distortion import MotionDistortion
from amorsim.noise.noise_floor import NoiseFloor
from amorsim.noise.odometry_model import OdometryModel
from amorsim.noise.outliers import Outliers
from amorsim.noise.quantize import Quantize
from amorsim.noise.saturate import Saturate
from amorsim.noise.scale import Scale
from amorsim.noise.slip import Slip
from amorsim.noise.specular_loss import SpecularLoss
from amorsim.noise.stuck import Stuck
from amorsim.noise.velocity_model import VelocityModel

__all__ = [
    "AimGaussian",
    "AngleRandomWalk",
    "BeamModel",
    "Bias",
    "BiasInstability",
    "BiasRandomWalk",
    "Bump",
    "CompassDeviation",
    "CrossTalk",
    "Diffusion",
    "Dropout",
    "Gaussian",
    "LatencyJitter",
    "Missed",
    "MotionDistortion",
    "NoiseFloor",
    "OdometryModel",
    "Outliers",
    "Quantize",
    "Saturate",
    "Scale",
    "Slip",
    "SpecularLoss",
    "Stuck",
    "VelocityModel",
]
