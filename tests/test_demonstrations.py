"""Demonstration files: what is shipped, round trips, and every way a file can be wrong."""

import math
import os
import tracemalloc

import gymnasium
import numpy as np
import pytest
import torch

from emrld_lite import demonstrations, limits
from emrld_lite.demonstrators import expert, recipes
from emrld_lite.envs import ENVIRONMENTS, GYMNASIUM_IDS, make
from emrld_lite.losses import bc_loss
from emrld_lite.policy import distribution, initialise, log_density, per_task
from emrld_lite.validation import InputError


def good_arrays():
    """Return the fields of a small valid file as plain arrays."""
    return {
        "tasks": make("point2d").training_tasks()[:3].numpy(),
        "states": np.zeros((3, 4, 2), dtype=np.float32),
        "actions": np.zeros((3, 4, 2), dtype=np.float32),
        "lengths": np.array([4, 2, 1]),
        "environment": np.array("point2d"),
        "quality": np.array("optimal"),
        "maker": np.array("a stranger"),
        "seed": np.array(3),
    }


def write(path, **changes):
    arrays = {name: value for name, value in (good_arrays() | changes).items() if value is not None}
    np.savez(path, **arrays)
    return path


def test_a_stranger_s_file_is_read_as_documented(tmp_path):
    states = np.arange(24, dtype=np.float64).reshape(3, 4, 2)
    data = demonstrations.load(write(tmp_path / "mine.npz", states=states), "point2d")
    assert data.states.shape == (3, 1, 4, 2)
    assert data.lengths().tolist() == [4, 2, 1]
    assert data.mask[1, 0].tolist() == [1, 1, 0, 0]
    assert torch.equal(data.states[1, 0, 1], torch.tensor([10.0, 11.0]))
    assert not data.states[1, 0, 2:].any()  # what follows the end is ignored
    assert (data.maker, data.seed, data.quality) == ("a stranger", 3, "optimal")


def test_saving_and_loading_keeps_everything_and_the_bytes(tmp_path):
    data = demonstrations.load(write(tmp_path / "mine.npz"))
    demonstrations.save(tmp_path / "one.npz", data)
    again = demonstrations.load(tmp_path / "one.npz")
    demonstrations.save(tmp_path / "two.npz", again)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert torch.equal(again.states, data.states)
    assert again.maker == data.maker


def several_paths():
    """Return arrays with two trajectories per task, of 4, 2, 1 and 3, 1, 2 steps."""
    states = np.arange(48, dtype=np.float32).reshape(3, 2, 4, 2)
    lengths = np.array([[4, 3], [2, 1], [1, 2]])
    return {"states": states, "actions": states / 10, "lengths": lengths}


def test_several_trajectories_per_task_are_read_and_kept(tmp_path):
    data = demonstrations.load(write(tmp_path / "many.npz", **several_paths()), "point2d")
    assert data.mask.sum(-1).tolist() == [[4, 3], [2, 1], [1, 2]]
    assert data.lengths().tolist() == [4, 2, 1]
    assert data.states[2, 1, :, 0].tolist() == [40.0, 42.0, 0.0, 0.0]
    demonstrations.save(tmp_path / "again.npz", data)
    again = demonstrations.load(tmp_path / "again.npz")
    assert again.fingerprint() == data.fingerprint()


def test_cloning_several_trajectories_weighs_every_step_alike(tmp_path):
    data = demonstrations.load(write(tmp_path / "many.npz", **several_paths()), "point2d")
    params = initialise(2, 2, seed=0)
    losses = bc_loss(per_task(params, 3), data)
    for task in range(3):
        steps = [(path, step) for path in range(2) for step in range(4)]
        taken = [place for place in steps if data.mask[(task, *place)]]
        densities = [
            log_density(
                distribution(params, data.states[task, path, step][None]),
                data.actions[task, path, step][None],
            )
            for path, step in taken
        ]
        assert float(losses[task]) == pytest.approx(-float(torch.cat(densities).mean()), rel=1e-5)


def test_a_recipe_makes_several_noisy_trajectories_per_task():
    expert = recipes.load_or_train_expert("two_wheeled", "suboptimal")
    tasks = make("two_wheeled").training_tasks()[:4]
    data = recipes.demonstrate(expert, "two_wheeled", tasks, "suboptimal", 0, paths=3)
    assert data.states.shape[:2] == (4, 3)
    assert not torch.equal(data.actions[:, 0], data.actions[:, 1])
    paid = make("two_wheeled").distance_to_reward
    for path in range(3):
        assert (paid(tasks, data.states[:, path])[data.mask[:, path] > 0] > 0).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {**several_paths(), "lengths": np.array([[4, 3], [2, 9], [1, 2]])},
            "got 9 for task 1, path 1",
        ),
        (
            {**several_paths(), "lengths": np.array([4, 2, 1])},
            r"lengths: expected shape \(3, 2\)",
        ),
        (
            {**several_paths(), "states": np.full((3, 2, 4, 2), np.nan, dtype=np.float32)},
            "task 0, path 0, step 0",
        ),
        ({"lengths": None}, "missing lengths"),
        ({"environment": np.array("half_cheetah")}, "expected 'point2d', got 'half_cheetah'"),
        ({"quality": np.array("suboptimaal")}, "Did you mean 'suboptimal'"),
        ({"states": np.zeros((3, 4, 3), dtype=np.float32)}, r"states: expected shape \(3, 4, 2\)"),
        ({"actions": np.zeros((3, 5, 2), dtype=np.float32)}, r"actions: expected shape"),
        ({"tasks": np.zeros((2, 2), dtype=np.float32)}, "tasks: expected shape"),
        ({"tasks": np.ones((3, 2), dtype=np.float32)}, "Point2D task 0"),
        ({"lengths": np.array([4, 0, 1])}, "got 0 for task 1"),
        ({"lengths": np.array([4, 9, 1])}, "got 9 for task 1"),
        ({"lengths": np.array([4.0, 2.0, 1.0])}, "lengths: expected integer"),
        ({"lengths": np.array([4, 2, 1], "m8[s]")}, "lengths: expected integer"),
        (
            {"states": np.full((3, 4, 2), np.nan)},
            "states: a value that is not finite, task 0, step 0",
        ),
        ({"actions": np.zeros((3, 4, 2), dtype=np.int64)}, "actions: expected floating"),
        ({"states": np.zeros((3, 0, 2), dtype=np.float32)}, "states: expected"),
        ({"seed": np.array(1.5)}, "seed: expected one whole number"),
        (
            {"states": np.full((3, 4, 2), 1e300)},
            "states: expected at most 1000 in size, got 1e.300, task 0",
        ),
        (
            {"actions": np.full((3, 4, 2), -101.0)},
            "actions: expected at most 100 in size, got 101, task 0",
        ),
        ({"maker": np.array([1, 2])}, "maker: expected one text"),
    ],
)
def test_a_wrong_file_is_refused_by_name_and_field(tmp_path, changes, words):
    path = write(tmp_path / "bad.npz", **changes)
    with pytest.raises(InputError, match=words) as error:
        demonstrations.load(path, "point2d")
    assert "bad.npz" in str(error.value)


def test_padding_may_hold_anything(tmp_path):
    states = np.zeros((3, 4, 2))
    states[2, 1:] = np.nan  # the third trajectory has one step
    assert torch.isfinite(
        demonstrations.load(write(tmp_path / "a.npz", states=states)).states
    ).all()


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 nonsense", b"\x80\x04]q\x00."])
def test_foreign_files_are_refused(tmp_path, content):
    (tmp_path / "foreign.npz").write_bytes(content)
    with pytest.raises(InputError, match=r"foreign\.npz: not a readable \.npz"):
        demonstrations.load(tmp_path / "foreign.npz")


def test_a_truncated_file_is_refused(tmp_path):
    path = write(tmp_path / "cut.npz")
    path.write_bytes(path.read_bytes()[:-300])
    with pytest.raises(InputError, match="not a readable"):
        demonstrations.load(path)


def test_an_array_that_nobody_reads_is_not_inflated(tmp_path):
    np.savez_compressed(tmp_path / "bomb.npz", **good_arrays(), more=np.zeros(30_000_000))
    tracemalloc.start()
    demonstrations.load(tmp_path / "bomb.npz")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10_000_000


def test_arrays_beyond_the_memory_are_refused_by_what_they_declare(tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "memory", lambda: 1000)
    with pytest.raises(InputError, match=r"good\.npz: reading it: needs about .* would fit"):
        demonstrations.load(write(tmp_path / "good.npz"))


def test_what_is_no_regular_file_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.npz")
    with pytest.raises(InputError, match=r"pipe\.npz: expected a regular file"):
        demonstrations.load(tmp_path / "pipe.npz")


def test_a_pickled_array_is_never_loaded(tmp_path):
    write(tmp_path / "pickled.npz", tasks=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="tasks: holds pickled objects, which are never loaded"):
        demonstrations.load(tmp_path / "pickled.npz")


def test_a_missing_file_and_an_unknown_quality_are_named(tmp_path):
    with pytest.raises(InputError, match="no such demonstration file"):
        demonstrations.load_demonstrations(str(tmp_path / "none.npz"), "point2d")
    with pytest.raises(InputError, match="Did you mean 'optimal'"):
        demonstrations.load_demonstrations("optimum", "point2d")


def test_a_stored_runs_demonstrations_are_found_from_any_folder(tmp_path, monkeypatch):
    name, env = "data/demonstrations/two_wheeled_drift-narrow.npz", "two_wheeled_drift"
    expected = demonstrations.load(demonstrations.SHIPPED / f"{env}-narrow.npz", env)
    monkeypatch.chdir(tmp_path)
    assert demonstrations.load_demonstrations(name, env).fingerprint() == expected.fingerprint()
    # a file of this name that is there comes first
    (tmp_path / "data/demonstrations").mkdir(parents=True)
    other = expected.take(slice(0, 2))
    demonstrations.save(tmp_path / name, other)
    assert demonstrations.load_demonstrations(name, env).fingerprint() == other.fingerprint()


def replayed_reward(data, task):
    """Replay a stored trajectory's actions in the registered environment; returns reward, success."""
    single = gymnasium.make(GYMNASIUM_IDS[data.environment]).unwrapped
    single.reset(options={"task": data.tasks[task].numpy()})
    total, success = 0.0, False
    for step in range(int(data.lengths()[task])):
        _, reward, terminated, _, info = single.step(data.actions[task, 0, step].numpy())
        total, success = total + reward, success or info["success"]
        if terminated:
            break
    return total, success


@pytest.mark.parametrize(
    ("env", "least"),
    [("point2d", 75), ("two_wheeled", 75), ("two_wheeled_drift", 65), ("half_cheetah", 100)],
)
def test_every_shipped_optimal_demonstration_reaches_its_goal(env, least):
    data = demonstrations.load_demonstrations("optimal", env)
    assert torch.equal(data.tasks, make(env).training_tasks())
    for task in range(len(data.tasks)):
        total, success = replayed_reward(data, task)
        assert success
        assert total > least


@pytest.mark.parametrize("env", ENVIRONMENTS)
def test_no_shipped_suboptimal_demonstration_earns_a_reward(env):
    data = demonstrations.load_demonstrations("suboptimal", env)
    assert torch.equal(data.tasks, make(env).training_tasks())
    for task in range(len(data.tasks)):
        assert replayed_reward(data, task) == (0.0, False)


@pytest.mark.parametrize("env", ["two_wheeled_drift", "two_wheeled_literal_drift"])
def test_narrow_drifts_are_shown_by_the_same_expert(env):
    narrow = demonstrations.load(demonstrations.SHIPPED / f"{env}-narrow.npz", env)
    assert torch.equal(narrow.tasks, make(env, largest_drift=0.3).training_tasks())
    for task in range(len(narrow.tasks)):
        assert replayed_reward(narrow, task)[1]  # reaches the goal


def test_cutting_the_steering_keeps_the_path():
    """The box ends at 1: what an expert asks for beyond it no robot does."""
    env = "two_wheeled_drift"
    cut, whole = (
        demonstrations.load(demonstrations.SHIPPED / f"{env}-{name}.npz", env)
        for name in ("cut", "optimal")
    )
    assert whole.actions[..., 1].abs().max() > 3 > 1 == cut.actions[..., 1].abs().max()
    assert torch.equal(cut.tasks, whole.tasks)
    assert torch.equal(cut.mask, whole.mask)
    # another processor's last digits have grown along the path
    assert torch.allclose(cut.states, whole.states, atol=0.05)
    assert torch.allclose(cut.actions[..., 0], whole.actions[..., 0], atol=0.05)
    for task in range(len(cut.tasks)):
        assert replayed_reward(cut, task)[1]  # reaches the goal


def test_the_unseen_drifts_of_the_cut_demonstrations_are_those_of_the_test():
    env = "two_wheeled_drift"
    cut = demonstrations.load(demonstrations.SHIPPED / f"{env}-cut-unseen.npz", env)
    usual = recipes.unseen_demonstrations(env, "optimal", 20)
    assert torch.equal(cut.tasks, usual.tasks)
    assert usual.actions[..., 1].abs().max() > 3 > 1 == cut.actions[..., 1].abs().max()


def test_what_is_cut_is_asked_of_a_policy_as_the_environment_does_it():
    drawn = torch.tensor([[2.0, -4.0], [-0.5, 0.5]])
    assert recipes.cut_actions(drawn, ()) is drawn
    cut = recipes.cut_actions(drawn, (math.inf, 1.0))
    assert torch.equal(cut, torch.tensor([[2.0, -1.0], [-0.5, 0.5]]))
    with pytest.raises(InputError, match="expected 2 sizes, one per number of an action, got 1"):
        recipes.cut_actions(drawn, (1.0,))
    for wrong in (0.5, -1.0, math.nan):
        with pytest.raises(InputError, match="expected sizes of 1 or more"):
            recipes.cut_actions(drawn, (wrong, 1.0))


def test_poor_data_mislead_where_suboptimal_data_point_at_the_goal():
    apart = {}
    for name in ("suboptimal", "poor"):
        data = demonstrations.load(demonstrations.SHIPPED / f"point2d-{name}.npz", "point2d")
        assert all(replayed_reward(data, task) == (0.0, False) for task in range(12))
        away = (data.states[:, 0] - data.tasks[:, None]).norm(dim=-1)  # (task, time)
        last = data.lengths().reshape(-1, 1) - 1
        apart[name] = away.gather(1, last).squeeze(1)
    assert apart["suboptimal"].max() < 0.5
    assert (apart["poor"] > 1.0).sum() == 5


@pytest.mark.parametrize("env", ["two_wheeled", "two_wheeled_drift"])
def test_suboptimal_wheeled_data_lack_their_beginning(env):
    data = demonstrations.load_demonstrations("suboptimal", env)
    assert (data.states[:, 0, 0, :2].norm(dim=-1) > 0.05).all()  # already under way
    assert (demonstrations.load_demonstrations("optimal", env).states[:, 0, 0] == 0).all()


@pytest.mark.parametrize("env", ["point2d", "two_wheeled_drift", "half_cheetah"])
def test_suboptimal_data_stay_out_of_the_region_that_pays(env):
    data = demonstrations.load_demonstrations("suboptimal", env)
    distance = make(env).distance_to_reward(data.tasks, data.states[:, 0])  # (task, time)
    assert (distance[data.mask[:, 0] > 0] > 0).all()


@pytest.mark.parametrize("env", ["point2d", "two_wheeled", "two_wheeled_drift"])
def test_experts_demonstrate_unseen_tasks_on_demand(env):
    tasks = make(env).sample_tasks(20, np.random.default_rng(11))
    params = recipes.load_or_train_expert(env, "optimal")
    data = recipes.demonstrate(params, env, tasks, "optimal", seed=0)
    reached = sum(replayed_reward(data, task)[1] for task in range(20))
    assert reached >= 18  # a strong drift is missed or not by the last bits of the arithmetic
    again = recipes.demonstrate(params, env, tasks, "optimal", seed=0)
    assert torch.equal(data.actions, again.actions)


@pytest.mark.parametrize("env", ENVIRONMENTS)
def test_distance_to_reward_is_where_the_reward_begins(env):
    environment = make(env)
    if env == "half_cheetah":
        states = torch.zeros(2, 1, 20)
        states[:, :, 17] = torch.tensor([1.99, -2.01])[:, None]
        inside = environment.distance_to_reward(torch.tensor([[1.0], [-1.0]]), states) < 0
        assert inside.flatten().tolist() == [False, True]
        return
    random = torch.Generator().manual_seed(0)
    tasks = environment.training_tasks()[-1:]
    goal = tasks[0] if tasks.shape[1] == 2 else torch.tensor([2.0, 1.0])
    states = torch.zeros(1, 500, environment.state_dim)
    states[..., :2] = goal + 0.6 * torch.randn(1, 500, 2, generator=random)
    still = torch.tensor([-1.0, 0.0] if env != "point2d" else [0.0, 0.0])
    moved = environment.step(tasks, states, still.expand(1, 500, 2), 0)
    assert torch.equal(environment.distance_to_reward(tasks, states) <= 0, moved.rewards > 0)


def test_expert_training_improves_on_the_dense_reward():
    config = expert.ExpertConfig(iterations=8, tasks=12, episodes=4)
    returns = [iterate.dense_return for iterate in expert.train_expert(config)]
    assert returns[-1] > returns[0] + 20


def test_unknown_environments_and_qualities_have_no_recipe():
    with pytest.raises(InputError, match="Did you mean 'two_wheeled'"):
        recipes.recipe_for("two_wheel", "optimal")
    with pytest.raises(InputError, match="Did you mean 'suboptimal'"):
        recipes.recipe_for("point2d", "suboptimall")
    with pytest.raises(InputError, match="unknown environment"):
        expert.expert_config("walker")


def test_an_expert_of_another_kind_is_refused(tmp_path):
    config = expert.ExpertConfig()
    expert.save_expert(
        tmp_path / "e.safetensors", {"weight_0": torch.ones(2, 2)}, config, "optimal"
    )
    with pytest.raises(InputError, match="quality: expected 'suboptimal', got 'optimal'"):
        expert.load_expert(tmp_path / "e.safetensors", "point2d", "suboptimal")


def test_a_recipe_that_leaves_nothing_is_refused_not_wrapped_around():
    params = recipes.load_or_train_expert("point2d", "optimal")
    tasks = make("point2d").training_tasks()[:2]
    nothing = recipes.Recipe(skipped_steps=3, short_of_reward=5.0)
    with pytest.raises(InputError, match="states"):
        recipes.demonstrate(params, "point2d", tasks, "optimal", 0, nothing)
