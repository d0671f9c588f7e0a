"""Notebook 05's pictures: one adaptation step on two quadratics, over the sliders' whole range."""

import numpy as np
import pytest
import torch

from emrld_lite.classroom.sketches.two_gates import two_gates
from emrld_lite.classroom.suspect import suspect_solver
from emrld_lite.classroom.widgets import one_step
from emrld_lite.validation import InputError

ALPHAS = np.round(np.arange(0.0, one_step.LARGEST_ALPHA + 1e-9, 0.005), 3).tolist()
THETAS = np.round(np.arange(-one_step.EDGE, one_step.EDGE + 1e-9, 0.5), 1).tolist()


def meta_loss(theta, alpha):
    """Return the mean loss after one step, by autograd and nothing else."""
    total = 0.0
    for curvature, optimum in zip((1.0, 9.0), (-1.0, 1.0), strict=True):

        def loss(x, curvature=curvature, optimum=optimum):
            return 0.5 * curvature * (x - optimum) ** 2

        (slope,) = torch.autograd.grad(loss(theta), theta, create_graph=True)
        total = total + loss(theta - alpha * slope) / 2
    return total


def slope_at(place, alpha):
    theta = torch.tensor(place, dtype=torch.float64, requires_grad=True)
    return float(torch.autograd.grad(meta_loss(theta, alpha), theta)[0])


@pytest.mark.parametrize("alpha", ALPHAS)
def test_the_whole_gradient_rests_where_autograd_is_zero(alpha):
    assert slope_at(one_step.resting_points(alpha)[0], alpha) == pytest.approx(0.0, abs=1e-9)


def first_order_descent(alpha, rounds):
    """Return where first-order steps lead from 0.3, two tasks with curvatures 1 and 9."""
    theta = 0.3
    for _ in range(rounds):
        flat, steep = theta - alpha * (theta + 1), theta - 9 * alpha * (theta - 1)
        theta -= 0.1 * ((flat + 1) + 9 * (steep - 1)) / 2
    return theta


@pytest.mark.parametrize("alpha", ALPHAS)
def test_first_order_descent_comes_to_rest_there_or_runs_away(alpha):
    rest = one_step.resting_points(alpha)[1]
    found = first_order_descent(alpha, 3000)
    if rest is None:
        assert abs(found) > 1e6
    else:
        assert found == pytest.approx(rest, abs=1e-6)


def test_first_order_runs_away_beyond_ten_eighty_seconds():
    assert one_step.resting_points(10 / 82 - 1e-4)[1] is not None
    assert one_step.resting_points(10 / 82 + 1e-4)[1] is None


@pytest.mark.parametrize("theta", THETAS)
def test_the_loss_after_the_step_is_the_one_by_autograd(theta):
    drawn = float(one_step.losses_after(theta, 0.07).mean())
    expected = meta_loss(torch.tensor(theta, requires_grad=True), 0.07).detach()
    assert drawn == pytest.approx(float(expected), rel=1e-5)


@pytest.mark.parametrize("alpha", ALPHAS[::3])
def test_the_picture_can_be_drawn_over_the_whole_range(alpha):
    for theta in (THETAS[0], 0.0, THETAS[-1]):
        figure = one_step.one_step_picture(alpha, theta)
        assert all(axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)
        low, high = figure.axes[0].get_xlim()
        assert all(low <= end <= high for end in one_step.adapted(theta, alpha))
        figure.canvas.draw()


def test_the_picture_names_where_the_gradients_rest():
    (_, right) = one_step.one_step_picture(0.1).axes
    words = [text.get_text() for text in right.get_legend().get_texts()]
    assert "whole gradient rests at -0.80" in words and "first order rests at +0.00" in words


@pytest.mark.parametrize(("alpha", "theta"), [(-0.1, 0.0), (0.2, 0.0), (0.1, 2.0)])
def test_numbers_beyond_the_sliders_are_refused(alpha, theta):
    with pytest.raises(InputError):
        one_step.one_step_picture(alpha, theta)


def test_the_drawing_names_both_gates():
    words = " ".join(text.get_text() for text in two_gates().axes[0].texts)
    assert "first gate" in words and "second gate" in words


def test_the_suspect_has_the_symptoms_that_the_notebook_reads():
    """Its second direction is parallel to the residual, and 1 + beta times as long."""
    matrix = torch.diag(torch.tensor([1.0, 10.0, 100.0], dtype=torch.float64))
    target, asked = torch.tensor([1.0, -2.0, 0.5], dtype=torch.float64), []
    suspect_solver(lambda v: (asked.append(v.clone()), matrix @ v)[1], target, 2)
    residual = target - matrix @ suspect_solver(lambda v: matrix @ v, target, 1)
    beta = residual @ residual / (target @ target)
    torch.testing.assert_close(asked[1], (1 + beta) * residual)
    assert suspect_solver(lambda v: v, 0 * target, 1).isnan().all()
