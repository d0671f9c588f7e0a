"""Attacks on the door: broken demonstration files, run folders, grids and command lines, by seed.

Each case runs in a process of its own with a time limit. It must end with a refusal in one line, or
with a result that shows that the input was usable after all.
"""

import contextlib
import dataclasses
import io
import json
import multiprocessing
import os
import pickle
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import safetensors.torch
import torch

from emrld_lite.__main__ import main
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load
from emrld_lite.envs import make
from emrld_lite.experiments import bench, checkpoints, commands, runs
from emrld_lite.experiments.grid import load_grid
from emrld_lite.trpo import TrustRegion
from emrld_lite.validation import InputError

LIMIT = 20.0  # seconds of a case on a busy machine; a case takes a tenth of a second
MEMORY = 4 * 10**9  # bytes that a case may take
BASE = TrainConfig(
    algorithm="gmps",
    iterations=2,
    episodes=1,
    trust_region=TrustRegion(fisher_samples=5, cg_iterations=1, backtracks=2),
)
DEEP = "[" * 100_000
JUNK = (
    None, True, False, "false", "", "\0", "nan", -1, 0, 1, 2.5, -1e-300, 1e300, float("nan"), float("inf"),
    10**9, 10**30, 10**4000, [], [1], {}, {"a": 1}, "x" * 3000, "../../x", "optimal", "\x1b[31m",
)  # fmt: skip


class Trouble(Exception):
    """What a case shows to be wrong with the door."""


# --- any file ----------------------------------------------------------------------------------


def flipped(random, content):
    data = bytearray(content)
    for place in random.integers(0, max(1, len(data)), random.integers(1, 8)):
        if data:
            data[place] ^= 1 << int(random.integers(8))
    return bytes(data)


def damaged(random, content):
    """Return content that was cut, spoiled, doubled, or replaced by something foreign."""
    place = int(random.integers(0, len(content) + 1))
    noise = random.bytes(int(random.integers(1, 200)))
    foreign = (b"", b"\0" * 100, b"PK\x03\x04nonsense", b"{}", b"[]", b"null", b"3", DEEP.encode(),
               pickle.dumps({"a": 1}), b"\x93NUMPY\x01\x00", content.decode("latin1").encode("utf-16"),
               b"1" * 5000, b'{"a":' * 50_000, b"\r\r\r", b"a,b\r1,2\r", b'"' + b"x" * 200_000)  # fmt: skip
    return (
        flipped(random, content),
        flipped(random, content),
        content[:place],
        content[:place] + noise + content[place:],
        content[:place] + noise + content[place + len(noise) :],
        content + content,
        foreign[random.integers(len(foreign))],
    )[random.integers(7)]


def special(random, path):
    """Put something at ``path`` that is no regular file of a sane size."""
    path.unlink(missing_ok=True)
    kind = random.integers(6)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.mkdir()
    elif kind == 2:
        path.symlink_to(("/dev/zero", "/dev/null", "/dev/tty")[random.integers(3)])
    elif kind == 3:
        path.symlink_to(path)
    elif kind == 4:
        path.touch()
        os.truncate(path, 10**13)
    return path


def bad_path(random, folder):
    names = ("nowhere.npz", "x" * 300 + ".npz", "a\0b.npz", "\udcff.npz", "", ".", "none/x.npz")
    return folder / names[random.integers(len(names))]


# --- demonstration files -----------------------------------------------------------------------


def good_arrays():
    return {
        "tasks": make("point2d").training_tasks()[:3].numpy(),
        "states": np.zeros((3, 4, 2), dtype=np.float32),
        "actions": np.full((3, 4, 2), 0.5, dtype=np.float32),
        "lengths": np.array([4, 2, 1]),
        "environment": np.array("point2d"),
        "quality": np.array("optimal"),
        "maker": np.array("a stranger"),
        "seed": np.array(3),
    }


def wrong_array(random, value):
    """Return another array in place of a good one."""
    dtypes = (
        "i8",
        "c16",
        "U9",
        "S3",
        "?",
        "f2",
        "f8",
        ">f4",
        "g",
        "m8[s]",
        "u8",
        [("a", "f4")],
        "f4",
    )
    spoiled = value.astype("f8") if value.dtype.kind in "fiu" else np.zeros(3)
    numbers = (np.nan, np.inf, -np.inf, 1e300, -1e30, 1e5, -1e5, 2.0**63, 0.0, -1.0)
    spoiled.flat[int(random.integers(spoiled.size))] = numbers[random.integers(len(numbers))]
    with contextlib.suppress(ValueError, TypeError):
        if random.integers(3) == 0:
            return np.zeros(value.shape, dtypes[random.integers(len(dtypes))])
    shapes = ((), (0,), (1,), (3, 0, 2), value.shape[::-1], (*value.shape, 1), (1, 1, 1, 1))
    return (
        spoiled,
        spoiled.astype("f4") if random.integers(2) else np.nan_to_num(spoiled).astype("i8"),
        np.zeros(shapes[random.integers(len(shapes))], value.dtype),
        np.array({"a": 1}, dtype=object),
        np.array("word \n word"),
        np.array(10**15),
    )[random.integers(6)]


def npy(value, allow_pickle=True):
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, value, allow_pickle=allow_pickle)
    return buffer.getvalue()


def odd_header(random, content):
    """Return a .npy whose header was spoiled, or declares much more than there is."""
    shapes = (b"(9999999999999, 2)", b"(-1, 4, 2)", b"(3, 4, 2", b"('a',)", b"9", b"(" * 300)
    start, end = content.index(b"(") if b"(" in content else 10, content.find(b")", 10) + 1
    return (
        flipped(random, content[:80]) + content[80:],
        content[:start] + shapes[random.integers(len(shapes))] + content[end:],
        content[:6] + bytes([int(random.integers(5)), int(random.integers(3))]) + content[8:],
        content[:8] + random.bytes(2) + content[10:],
        content.replace(b"descr", b"descr'"[:6]).replace(b"fortran", b"\n\n"),
        b"",
    )[random.integers(6)]


def odd_archive(random, path):
    """Write an archive whose parts are good, or nearly, and whose whole is odd."""
    members = {f"{name}.npy": npy(value) for name, value in good_arrays().items()}
    name = list(members)[random.integers(len(members))]
    kind = random.integers(7)
    if kind < 3:
        members[name] = odd_header(random, members[name])
    method = zipfile.ZIP_DEFLATED if random.integers(2) else zipfile.ZIP_STORED
    with zipfile.ZipFile(path, "w", method) as archive:
        for one, content in members.items():
            archive.writestr(one, content)
        if kind == 3:
            archive.writestr("more.npy", b"\0" * 10**8)  # read by nobody
        if kind == 4:
            archive.writestr(f"{DEEP[:1000]}.npy", b"junk")
    content = bytearray(path.read_bytes())
    entry = content.rfind(b"PK\x01\x02")  # of the last member
    if kind == 5 and entry > 0:
        content[entry + int(random.integers(4, 46))] ^= 1 << int(random.integers(8))
    if kind == 6:
        head = content.find(b"PK\x03\x04")
        content[head + int(random.integers(4, 30))] ^= 1 << int(random.integers(8))
    path.write_bytes(bytes(content))


def attack_demonstrations(random, folder, base):
    """Break a demonstration file and load it, then train on it if it was taken."""
    path, kind, arrays = folder / "mine.npz", random.integers(10), good_arrays()
    name = list(arrays)[random.integers(len(arrays))]
    if kind < 4:
        arrays[name] = wrong_array(random, arrays[name])
    if kind == 4:
        del arrays[name]
    (np.savez if random.integers(2) else np.savez_compressed)(path, **arrays)
    if kind in (5, 6):
        path.write_bytes(damaged(random, path.read_bytes()))
    elif kind == 7:
        special(random, path)
    elif kind == 8:
        odd_archive(random, path)
    elif kind == 9:
        path = bad_path(random, folder)
    taken = load(path, "point2d")
    with np.load(path, allow_pickle=False) as archive:
        data = {one: archive[one] for one in arrays}
    lengths = data["lengths"].astype(int)
    for task, length in enumerate(lengths):
        for field in ("states", "actions"):
            same(data[field][task, :length].astype("f4"), getattr(taken, field)[task, 0, :length])
    main(["train", "--demos", str(path), "--iterations", "1", "--episodes", "2", "--threads", "1",
          "--fisher-samples", "5", "--reward", "dense", "--out", str(folder / "run")])  # fmt: skip
    if "skipped" in runs.load_run(folder / "run").curve[0].note:
        raise Trouble("training on it skips its step")


def same(one, other):
    if not np.isfinite(one).all() or not np.array_equal(one, np.asarray(other)):
        raise Trouble("taken, but other numbers than the file's, or not finite ones")


# --- run folders -------------------------------------------------------------------------------


def odd_config(random, content):
    entries = json.loads(content)
    place = entries["trust_region"] if random.integers(4) == 0 else entries
    name = [*place, "other"][random.integers(len(place) + 1)]
    place[name] = JUNK[random.integers(len(JUNK))]
    if random.integers(6) == 0:
        del place[name]
    limit = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(0)
    text = json.dumps(entries)
    sys.set_int_max_str_digits(limit)
    return text.encode()


def odd_curve(random, content):
    lines = content.decode().splitlines()
    rows, row = lines[1:], int(random.integers(1, len(lines)))
    cells = lines[row].split(",")
    junk = ("", "-1", "nan", "inf", "x", "1e999", "1" * 5000, "y" * 200_000, "0", "1", "\r", '"')
    cells[random.integers(len(cells))] = junk[random.integers(len(junk))]
    spoiled = [*lines[:row], ",".join(cells), *lines[row + 1 :]]
    return "\n".join(
        (
            spoiled,
            spoiled,
            spoiled,
            [lines[0], *rows[::-1]],
            [*lines, rows[-1]],
            lines[:row],
            lines[1:],
            [*lines, "1,2"],
            [lines[0] + ",more", *(one + ",1" for one in rows)],
        )[random.integers(9)]
    ).encode()


def odd_policy(random, content):
    tensors = safetensors.torch.load(content)
    size = int.from_bytes(content[:8], "little")
    facts = json.loads(content[8 : 8 + size])["__metadata__"]
    name = list(tensors)[random.integers(len(tensors))]
    kinds = (torch.float64, torch.float16, torch.bfloat16, torch.int64, torch.bool, torch.complex64)
    numbers = (float("nan"), float("inf"), -1.0, 1e30, 0.25)
    kind = random.integers(8)
    if kind == 0:
        tensors[name] = tensors[name].to(kinds[random.integers(len(kinds))])
    elif kind == 1:
        tensors[name].view(-1)[0] = numbers[random.integers(len(numbers))]
    elif kind == 2:
        tensors[name] = tensors[name][None].repeat(2, *[1] * tensors[name].dim())
    elif kind == 3:
        del tensors[name]
    elif kind == 4:
        tensors["more"] = torch.zeros(2)
    elif kind == 5:
        facts.pop("iterations", None)
    elif kind == 6:
        odd = ("-3", "0", "1", "5", "x", "", "2.0", "1" * 5000, "٢")
        facts["iterations"] = odd[random.integers(len(odd))]
    else:
        facts["environment"] = ("half_cheetah", "", "x")[random.integers(3)]
    return safetensors.torch.save(tensors, facts)


def odd_provenance(random, content):
    facts = json.loads(content)
    odd = (50_000, 2**31, 10**30, -1, 0, "2", 2.5, True, [1], {}, "x")
    name = "threads" if random.integers(3) else "resumed"
    facts[name] = odd[random.integers(len(odd))]
    return json.dumps(facts).encode()


ODD = {
    "config.json": odd_config,
    "curve.csv": odd_curve,
    "policy.safetensors": odd_policy,
    "provenance.json": odd_provenance,
}


def attack_run(random, folder, base):
    """Break a file of a run, then resume it: refused, or to the curve of the run that never stopped."""
    shutil.copytree(base / "short", folder / "run")
    name = list(ODD)[random.integers(4)]
    path, kind = folder / "run" / name, random.integers(8)
    if kind < 5:
        path.write_bytes(ODD[name](random, path.read_bytes()))
    elif kind < 7:
        path.write_bytes(damaged(random, path.read_bytes()))
    elif random.integers(2):
        special(random, path)
    else:
        path.unlink()
    if random.integers(3) == 0:
        main(["evaluate", "--run", str(folder / "run"), "--tasks", "1", "--steps", "0", "--episodes", "1",
              "--out", str(folder / "t.csv")])  # fmt: skip
        return
    main(["train", "--algorithm", "gmps", "--episodes", "1", "--iterations", "3", "--fisher-samples", "5",
          "--cg-iterations", "1", "--backtracks", "2", "--resume", "--out", str(folder / "run")])  # fmt: skip
    resumed, straight = (
        [row._replace(seconds=0.0) for row in runs.load_run(one).curve]
        for one in (folder / "run", base / "long")
    )
    if resumed != straight:
        raise Trouble("resumed to another curve")


# --- grids -------------------------------------------------------------------------------------


def attack_grid(random, folder, base):
    """Break a grid and read it; what is taken must be runs."""
    path = folder / "grid.toml"
    option = (
        "seed",
        "episodes",
        "normalise",
        "demos",
        "w_rl",
        "max_kl",
        "name",
        "env",
        "iterations",
    )
    values = ("'x'", "''", "true", "'false'", "nan", "inf", "-1", "0", "1e400", "0x" + "f" * 5000,
              "9" * 5000, "[]", "[[1]]", "[1, 'a']", "{a = 1}", "1979-05-27", "'\\u0000'", '"\\u0000"',
              DEEP, "[" + "1," * 200_000 + "]", "'" + "x" * 400 + "'", "'{seed:>999999999}'",
              "'{seed.__class__}'", "'{}'", "'{'", "'a/b'", "'..'", "3", "[1, 1]", "'optimal'", "'a\\nb'",
              "\"a\\nb\"")  # fmt: skip
    body = f"{option[random.integers(len(option))]} = {values[random.integers(len(values))]}\n"
    many = "\n".join(f"{one} = [{', '.join(map(str, range(1, 90)))}]" for one in
                     ("seed", "episodes", "iterations", "fisher_samples", "cg_iterations"))  # fmt: skip
    texts = (
        f"[[runs]]\n{body}",
        f"[[runs]]\nseed = 1\n{body}",
        f"[[runs]]\n{body}{body}",
        f"[[runs]]\n{many}\n",
        "runs = [1, 'a', [2]]\n",
        f"runs = {DEEP}",
        f"[runs]\n{body}",
        f"[[runs]]\n[[runs.{body.partition(' ')[0]}]]\na = 1\n",
        "[[runs]]\nseed = [0, 1]\nalgorithm = ['gmps', 'maml']\n",
    )
    content = texts[min(int(random.integers(14)), len(texts) - 1 if random.integers(4) else 1)]
    path.write_text(content, encoding="utf-8")
    kind = random.integers(8)
    if kind == 0:
        path.write_bytes(damaged(random, path.read_bytes()))
    elif kind == 1:
        special(random, path)
    grid = load_grid(path)
    for name, config in grid.items():
        kinds = {"normalise": bool, "seed": int, "episodes": int, "demos": str}
        strict = all(type(getattr(config, field)) is kind for field, kind in kinds.items())
        if not strict or not name or not name.isprintable() or len(name.encode()) > 240:
            raise Trouble(f"taken as a run: {name[:50]!r}, {str(config)[:300]}")
    if not 1 <= len(grid) <= 10_000:
        raise Trouble(f"a grid of {len(grid)} runs")


# --- command lines -----------------------------------------------------------------------------

WORDS = ("", " ", "-1", "0", "nan", "inf", "-inf", "1e400", "9" * 5000, "x", "None", "true", "1.5",
         "10000000000000000000000", "\0", "/dev/null", "/dev/full", "/proc/nothing/x.csv", "x" * 300,
         "\udcff", "'", "--", "-", "a\nb", "\x1b[2J", "1e-320", "1e300", "1_000_000_000_000_000")  # fmt: skip
COUNTS = ("1000000000", "2147483647", "2147483648", "10000000", "18446744073709551616")


def attack_command(random, folder, base):
    """Give a command options that it cannot use, among good ones."""
    out = str(folder / "out")
    commands = {
        "train": {"--iterations": "1", "--episodes": "1", "--seed": "1", "--threads": "1",
                  "--demos": "optimal",
                  "--algorithm": "gmps", "--adapt-lr": "0.1", "--w-rl": "1", "--fisher-samples": "5",
                  "--damping": "0.1", "--max-kl": "0.1", "--backtracks": "1", "--cg-iterations": "1",
                  "--discount": "0.9", "--stop-at-return": "1", "--meta-lr": "0.1", "--out": out,
                  "--device": "cpu", "--env": "point2d", "--reward-elsewhere": "0"},
        "evaluate": {"--run": str(base / "short"), "--tasks": "1", "--steps": "0", "--episodes": "1",
                     "--seed": "1", "--threads": "1", "--later-rate": "0.1", "--out": f"{out}.csv"},
        "demos": {"--env": "point2d", "--quality": "optimal", "--tasks": "1", "--noise": "0.1", "--seed": "1",
                  "--threads": "1", "--out": f"{out}.npz"},
        "figures": {"--out": out, "--runs-folder": str(folder / "nowhere")},
        "bench": {"--iterations": "0", "--tasks": "1", "--threads": "1"},
    }  # fmt: skip
    command = (
        "train",
        "train",
        "train",
        "evaluate",
        "evaluate",
        "demos",
        "demos",
        "figures",
        "bench",
    )[random.integers(9)]
    options = commands[command]
    for _ in range(int(random.integers(1, 3))):
        name = list(options)[random.integers(len(options))]
        counted = name in ("--threads", "--seed", "--episodes", "--tasks", "--steps", "--fisher-samples",
                           "--backtracks", "--cg-iterations")  # fmt: skip
        words = COUNTS if counted and random.integers(2) else WORDS
        options[name] = words[random.integers(len(words))]
    if command == "train" and options["--algorithm"] == "gmps" and random.integers(2):
        options["--algorithm"] = "emrld-ws"
    arguments = [command, *(word for pair in options.items() for word in pair)]
    if random.integers(8) == 0:
        arguments.insert(int(random.integers(len(arguments))), WORDS[random.integers(len(WORDS))])
    os.chdir(folder)
    main(arguments)
    if command == "train":
        run = runs.load_run(Path(options["--out"]))
        if not all(torch.isfinite(value).all() for value in run.meta_params.values()):
            raise Trouble("a policy that is not finite")


# --- the judge ---------------------------------------------------------------------------------

# loaded before a process is made for each case; torch loads much when its first optimiser is made,
# and the first command line that is read costs five times the next
LOADED = (main, commands, bench, BASE.learner(BASE.initial_policy()))
with contextlib.suppress(SystemExit), contextlib.redirect_stderr(io.StringIO()):
    main(["train", "--out", ""])
ATTACKS = {
    "demonstrations": attack_demonstrations,
    "run": attack_run,
    "grid": attack_grid,
    "command": attack_command,
}


def prepare(base):
    """Make the run that is broken, and the one that never stopped."""
    torch.set_num_threads(1)
    checkpoints.train_run(BASE, base / "short")
    checkpoints.train_run(dataclasses.replace(BASE, iterations=3), base / "long")


def judged(family, seed, base):
    """Run one case in this process; returns what is wrong, or how it ended well."""
    torch.set_num_threads(1)
    said = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stderr(said):
        random = np.random.default_rng([seed, *family.encode()])
        try:
            ATTACKS[family](random, Path(folder), Path(base))
        except SystemExit as stop:
            lines = said.getvalue().splitlines()
            if stop.code != 2 or len(lines) != 1 or not lines[0].isprintable():
                return f"exit {stop.code} with {said.getvalue()[-500:]!r}"
            return "refused"
        except (InputError, OSError) as error:
            if len(str(error).splitlines()) != 1 or "allow_pickle" in str(error):
                return f"a refusal that is not one line: {str(error)[:500]!r}"
            return "refused"
        except Trouble as trouble:
            return f"taken: {trouble}"
        except BaseException as error:  # whatever else comes through is what is looked for
            return f"{type(error).__name__}: {str(error)[:300]}"
        finally:
            os.chdir("/")
    return "used"


def child(family, seed, base, answer):
    """Judge one case behind limits and tell the parent."""
    import resource  # noqa: PLC0415  (not on Windows)

    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    answer.send(judged(family, seed, base))


def attack(cases, base, families=tuple(ATTACKS), start=0):
    """Try ``cases`` of each family; yields family, seed and how each ended."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.door", "distributed"])
    for family in families:
        for seed in range(start, start + cases):
            parent, answer = context.Pipe(duplex=False)
            process = context.Process(target=child, args=(family, seed, str(base), answer))
            process.start()
            answer.close()
            try:
                verdict = parent.recv() if parent.poll(LIMIT) else f"still running after {LIMIT} s"
            except EOFError:
                process.join(timeout=LIMIT)
                verdict = f"the process ended with {process.exitcode}"
            process.join(timeout=1.0)
            process.kill()
            process.join()
            yield family, seed, verdict
