"""Sine and cosine of parts of a quarter turn, by sums and products alone.

Without a branch or a call, so that compilers make loops over them several numbers wide, and with the same bits on every
processor, whatever its library of mathematics.
"""

from __future__ import annotations

from amorsim.kernels.compile import inlined

__all__ = ["cosine_of_quarters", "sine_of_quarters"]

# Taylor's coefficients of sine and cosine of r quarter turns, (pi / 2)**k / k!: for r of at most a half the terms left
# out are below 5e-17 and 3e-18.
_S0, _S1, _S2, _S3 = 1.5707963267948966, -0.6459640975062463, 0.07969262624616705, -0.004681754135318688
_S4, _S5, _S6, _S7 = 0.00016044118478735983, -3.598843235212085e-06, 5.692172921967927e-08, -6.688035109811468e-10
_C1, _C2, _C3, _C4 = -1.2337005501361697, 0.25366950790104803, -0.02086348076335296, 0.0009192602748394266
_C5, _C6, _C7, _C8 = -2.5202042373060607e-05, 4.710874778818172e-07, -6.386603083791852e-09, 6.565963114979473e-11


@inlined
def sine_of_quarters(r: float) -> float:
    """The sine of r quarter turns, r from -1/2 to 1/2."""
    z = r * r
    return r * (_S0 + z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * (_S6 + z * _S7)))))))


@inlined
def cosine_of_quarters(r: float) -> float:
    """The cosine of r quarter turns, r from -1/2 to 1/2."""
    z = r * r
    return 1.0 + z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * (_C6 + z * (_C7 + z * _C8)))))))
