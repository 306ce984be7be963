"""What devices do to the quantities they measure, and what the ground does to wheels: elements of chains."""

from __future__ import annotations

from amorsim.noise.aim_gaussian import AimGaussian
from amorsim.noise.bias import Bias
from amorsim.noise.diffusion import Diffusion
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.quantize import Quantize
from amorsim.noise.saturate import Saturate
from amorsim.noise.scale import Scale

__all__ = ["AimGaussian", "Bias", "Diffusion", "Gaussian", "Quantize", "Saturate", "Scale"]
