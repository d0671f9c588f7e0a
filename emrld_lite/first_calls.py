"""First calls of MKL's vector functions, made on one number before threads can race for them.

The first call of each chooses its kernel. When threads make it together, one of them may compute its
share with a few correct bits only (pytorch issue 188792, all torch builds with MKL before 2025).
"""

import torch

FUNCTIONS = (
    "acos", "asin", "atan", "cos", "cosh", "erf", "erfc", "erfinv", "exp", "expm1", "log", "log10",
    "log1p", "log2", "sin", "sinh", "sqrt", "tan", "tanh",
)  # fmt: skip
"""Every function of one argument that torch may hand to MKL."""


def make_first_calls() -> None:
    """Call each function once in each precision; takes under a millisecond."""
    for dtype in (torch.float32, torch.float64):
        number = torch.full((1,), 0.5, dtype=dtype)
        for name in FUNCTIONS:
            getattr(torch, name)(number)


make_first_calls()
