"""Sliders on Theorem 1: one moves the family and shows its waterfall, one breaks what the proof needs."""

from __future__ import annotations

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.figure import Figure

from ...tabular import Claims, corridor_step, proof_lines, slippery_pair, theorem_1
from ...tabular.families import Family
from ...tabular.figures import slacks
from ...validation import check_choice
from ..proof_drops import MOVES
from ..sketches.waterfall import waterfall
from .answer import as_image

FALSE_CLAIMS = (
    "nothing",
    "Delta is claimed too large",
    "C1 is claimed too small",
    "the critic is wrong at the start",
    "distance is measured on the demonstrator's states",
)
FAST = {"layout": "none"}  # a picture that follows a slider has its margins set by hand


def bound_sliders() -> None:
    """Show sliders for the corridor family and the waterfall from its improvement to the bound."""

    def show(quality: float, share: float, discount: float, stubbornness: float) -> None:
        display(as_image(bound_picture(quality, share, discount, stubbornness)))

    unit = {"min": 0.0, "max": 1.0, "step": 0.05, "continuous_update": False}
    ipywidgets.interact(
        show,
        quality=ipywidgets.FloatSlider(value=0.8, **unit),
        share=ipywidgets.FloatSlider(value=0.5, description="step", **unit),
        discount=ipywidgets.FloatSlider(
            value=0.9, min=0.0, max=0.99, step=0.01, description="gamma", continuous_update=False
        ),
        stubbornness=ipywidgets.FloatSlider(value=0.6, description="stubborn", **unit),
    )


def bound_picture(
    quality: float = 0.8, share: float = 0.5, discount: float = 0.9, stubbornness: float = 0.6
) -> Figure:
    """Return the waterfall of ``corridor_step`` with these numbers, in return per step."""
    family = corridor_step(quality, share, discount, stubbornness)
    figure, axes = plt.subplots(figsize=(8.4, 3.6), **FAST)
    figure.subplots_adjust(left=0.33, bottom=0.14)
    waterfall(axes, family, per_step=True, named=True)
    theorem = theorem_1(*family)
    axes.set_title(
        f"Delta = {float(theorem.delta):.3f} at the worst state, "
        f"{float(theorem.average_delta):.3f} on average"
    )
    plt.close(figure)
    return figure


def assumption_sliders() -> None:
    """Show what the proof takes for granted, a slider that breaks it, and which moves then fail."""

    def show(claim: str, amount: float) -> None:
        display(as_image(assumption_picture(claim, amount)))

    ipywidgets.interact(
        show,
        claim=ipywidgets.Dropdown(
            options=FALSE_CLAIMS,
            value=FALSE_CLAIMS[-1],
            description="false:",
            layout={"width": "30em"},
        ),
        amount=ipywidgets.FloatSlider(
            value=1.0, min=0.0, max=1.0, step=0.05, continuous_update=False
        ),
    )


def assumption_picture(claim: str = FALSE_CLAIMS[-1], amount: float = 1.0) -> Figure:
    """Return how far each line of the proof holds when one claim is false by ``amount``, 0 to 1."""
    family, claims = broken(claim, amount)
    lines = proof_lines(*family, claims)
    fallen = [line for line in lines if not line.holds()]
    figure, axes = plt.subplots(figsize=(7.6, 4.6), **FAST)
    figure.subplots_adjust(left=0.3)
    slacks([line._replace(name=MOVES[line.name]) for line in lines], axes)
    axes.minorticks_off()
    first = (
        f"first to fail: {MOVES[fallen[0].name]}\n({fallen[0].rule})"
        if fallen
        else "every move holds"
    )
    axes.set_title(first, fontsize=10)
    plt.close(figure)
    return figure


def broken(claim: str, amount: float) -> tuple[Family, Claims]:
    """Return a family and what is claimed of it, with one claim false by ``amount``, 0 to 1."""
    check_choice("claim", claim, FALSE_CLAIMS)
    family = corridor_step()
    truth = theorem_1(*family)
    c1, delta = float(truth.c1), float(truth.delta)
    error = torch.tensor([0, 0, amount, 0, 0], dtype=torch.float64)
    slip = slippery_pair(slip=0.15 * amount)
    return {
        "nothing": (family, Claims()),
        "Delta is claimed too large": (family, Claims(delta=delta + amount * c1)),
        "C1 is claimed too small": (family, Claims(c1=(1 - amount) * c1)),
        "the critic is wrong at the start": (family, Claims(value_error=error)),
        "distance is measured on the demonstrator's states": (
            slip,
            Claims(demonstrator_states=True),
        ),
    }[claim]
