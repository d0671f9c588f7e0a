"""Sliders on the two-state family: what the demonstrator's states promise, and what comes of it."""

from __future__ import annotations

import ipywidgets
import matplotlib.pyplot as plt
from IPython.display import display
from matplotlib.figure import Figure

from ...tabular import related_bounds, slippery_pair, theorem_1
from ...tabular.figures import LOOKS as BOUND_LOOKS
from ..sketches.swamp import two_states
from .answer import as_image

HATCHES = {"substituted": "//", "improvement": "", "bound": ".."}


def swamp_sliders() -> None:
    """Show sliders for the discount, the slip into the swamp, and the demonstrator's lead."""

    def show(discount: float, slip: float, lead: float) -> None:
        display(as_image(swamp_picture(discount, slip, lead)))

    step = {"step": 0.01, "continuous_update": False}
    ipywidgets.interact(
        show,
        discount=ipywidgets.FloatSlider(value=0.98, min=0.0, max=0.99, description="gamma", **step),
        slip=ipywidgets.FloatSlider(value=0.02, min=0.0, max=0.25, **step),
        lead=ipywidgets.FloatSlider(value=0.25, min=0.0, max=0.25, description="lead x", **step),
    )


def swamp_picture(discount: float = 0.98, slip: float = 0.02, lead: float = 0.25) -> Figure:
    """Return the two states under the new policy, and beside them two promises and the truth."""
    family = slippery_pair(discount, slip, lead)
    (mdp,), _, _, (new,), _ = family
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(10.5, 2.9), width_ratios=(1.6, 1), layout="none"
    )
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.17, top=0.98, wspace=0.42)
    two_states(left, mdp, new, mdp.visitation(new))
    for place, (name, value) in enumerate(per_step(discount, slip, lead).items()):
        right.barh(
            place,
            value,
            0.6,
            color=BOUND_LOOKS[name]["color"],
            hatch=HATCHES[name],
            edgecolor="white",
        )
        right.annotate(
            f"{value:+.2f}", (max(value, 0), place), (4, 0), textcoords="offset points", va="center"
        )
    right.axvline(0, color="black", linewidth=0.8)
    names = (
        "promised with the\ndemonstrator's states",
        "true improvement",
        "promised by\nTheorem 1 as printed",
    )
    right.set_yticks(range(3), names)
    right.set(xlim=(-2.4, 1.2), ylim=(2.5, -0.5), xlabel="return per step")
    plt.close(figure)
    return figure


def per_step(discount: float, slip: float, lead: float) -> dict[str, float]:
    """Return what the substituted and the printed bound promise per discounted step, and the truth."""
    family = slippery_pair(discount, slip, lead)
    theorem, related = theorem_1(*family), related_bounds(*family)
    values = (related.substituted, theorem.improvement, theorem.bound)
    return {
        name: (1 - discount) * float(value) for name, value in zip(HATCHES, values, strict=True)
    }
