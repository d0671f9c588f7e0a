import torch


def _noise(estimates):
    return (estimates - estimates.mean(0)).square().sum(1).mean().sqrt()


def _compare(draw, estimate, baselines, batches, noise):
    seen = [draw() for _ in range(batches)]
    found = {}
    for name, baseline in baselines.items():
        estimates = torch.stack([estimate(batch, baseline(batch)) for batch in seen])
        found[name] = (estimates, noise(estimates))
    return found


def batches_of_its_own(draw, estimate, baselines, batches):
    """luck of the draw"""
    found = {}
    for name, baseline in baselines.items():
        seen = [draw() for _ in range(batches)]
        estimates = torch.stack([estimate(batch, baseline(batch)) for batch in seen])
        found[name] = (estimates, _noise(estimates))
    return found


def one_batch(draw, estimate, baselines, batches):
    """a single batch"""
    batch = draw()
    return _compare(lambda: batch, estimate, baselines, batches, _noise)


def without_the_values(draw, estimate, baselines, batches):
    """left out"""
    nothing = {name: lambda batch: torch.zeros_like(batch[:, 0]) for name in baselines}
    return _compare(draw, estimate, nothing, batches, _noise)


def a_variance(draw, estimate, baselines, batches):
    """take its root"""
    return _compare(draw, estimate, baselines, batches, lambda e: _noise(e) ** 2)


def from_zero(draw, estimate, baselines, batches):
    """distance from zero"""

    def length(estimates):
        return estimates.square().sum(1).mean().sqrt()

    return _compare(draw, estimate, baselines, batches, length)


def per_parameter(draw, estimate, baselines, batches):
    """average over the parameters"""
    return _compare(
        draw, estimate, baselines, batches, lambda e: (e - e.mean(0)).square().mean().sqrt()
    )


def noise_of_each_parameter(draw, estimate, baselines, batches):
    """the noise as one number"""
    return _compare(draw, estimate, baselines, batches, lambda e: e.std(0))


def only_the_noise(draw, estimate, baselines, batches):
    """estimates and noise of nothing"""
    found = _compare(draw, estimate, baselines, batches, _noise)
    return {name: noise for name, (_, noise) in found.items()}


def ten_batches(draw, estimate, baselines, batches):
    """batches to be drawn"""
    return _compare(draw, estimate, baselines, 10, _noise)
