# SPDX-License-Identifier: Apache-2.0
"""What a user does by accident: colliding files, devices, Ctrl-C, libraries that warn, numbers too large."""

from __future__ import annotations

import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path
from types import SimpleNamespace

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result

from quadshade.cli import compiled_loops, interrupts
from quadshade.cli.main import main
from quadshade.contract.formats import GENERIC_HELP, Formats, parse_generics
from quadshade.errors import QuadshadeError
from quadshade.files import atomic
from quadshade.image import read_picture, write_png

TRIANGLE = {"vertices": [[1, 1], [9, 2], [3, 9]], "samples": {"r": [5]}}
CONTENT = json.dumps({"width": 10, "height": 10, "channels": ["r"], "triangles": [TRIANGLE]})


def quadshade(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def is_one_line(result: Result) -> bool:
    # On a slow machine a step that takes over two seconds is said before.
    lines = [line for line in result.stderr.splitlines() if not line.endswith(" ...")]
    return result.exit_code == 2 and len(lines) == 1 and lines[0].startswith("quadshade: error: ")


@pytest.fixture
def triangles(tmp_path: Path) -> Path:
    path = tmp_path / "triangles.json"
    path.write_text(CONTENT)
    return path


def test_an_input_or_another_output_is_not_overwritten(triangles: Path, tmp_path: Path) -> None:
    linked = tmp_path / "link.npz"
    linked.symlink_to(triangles)
    for outputs in (("-o", triangles), ("-o", linked), ("-o", tmp_path / "a", "--stats", tmp_path / "a")):
        assert is_one_line(quadshade("raster", triangles, *outputs))
    assert triangles.read_text() == CONTENT and sorted(tmp_path.iterdir()) == [linked, triangles]
    picture = tmp_path / "a.png"
    write_png(picture, np.zeros((9, 9, 3), dtype=np.uint8))
    assert is_one_line(quadshade("compare", picture, picture, "--heatmap", picture))
    assert is_one_line(quadshade("render", "sphere:24", "-o", picture, "--stats", picture))


def test_a_link_is_followed_and_a_pipe_is_written_to(tmp_path: Path) -> None:
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    atomic.write_json(tmp_path / "link", {"a": 1})
    assert (tmp_path / "link").is_symlink()
    assert json.loads((tmp_path / "target").read_text()) == {"a": 1}
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    atomic.check_writable(pipe, pipe)
    atomic.write_json(pipe, {"a": 1})
    assert json.loads(os.read(reader, 100)) == {"a": 1}
    os.close(reader)
    assert pipe.is_fifo()


def test_a_folder_that_cannot_be_written_is_said_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The new file is made beside the old one, also where a link leads there."""
    folder, old = tmp_path / "folder", tmp_path / "folder" / "old.png"
    folder.mkdir()
    old.touch()
    (tmp_path / "link.png").symlink_to(old)
    atomic.check_writable(old, tmp_path / "other.png")
    real = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != folder and real(path, mode))
    for path in (old, folder / "new.png", tmp_path / "link.png"):
        with pytest.raises(QuadshadeError, match="cannot write"):
            atomic.check_writable(path)


def test_pixels_may_go_nowhere(triangles: Path) -> None:
    """NumPy's zip cannot be written to a device, which says of itself that it can seek."""
    result = quadshade("raster", triangles, "-o", os.devnull)
    assert result.exit_code == 0, result.output
    assert Path(os.devnull).is_char_device()


def test_what_is_redirected_is_neither_replaced_nor_cut(triangles: Path, tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_text("before\n")
    command = [sys.executable, "-m", "quadshade", "raster", triangles, "-o", tmp_path / "pixels.npz"]
    for path in ("/dev/stdout", "/proc/self/fd/1"):
        with log.open("a") as stream:
            subprocess.run([*command, "--engine", "model", "--stats", path], stdout=stream, check=True)
    text = log.read_text()
    assert text.startswith("before\n{") and text.count('"clocks": ') == 2 == text.count("pixels.npz: ")


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="no /proc")
def test_a_folder_that_holds_no_files_is_said_before_the_work(triangles: Path, tmp_path: Path) -> None:
    """Root may write everywhere by its permissions."""
    output = tmp_path / "pixels.npz"
    assert is_one_line(quadshade("raster", triangles, "-o", output, "--stats", "/proc/stats.json"))
    assert not output.exists()


@pytest.mark.parametrize("command", ("render", "pack", "trade"))
def test_an_empty_size_is_none(tmp_path: Path, command: str) -> None:
    result = quadshade(command, "cube:1", "-o", tmp_path / "a", "--size", "")
    assert is_one_line(result) and not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ("frac_bits=1_0", "frac_bits=\u0663", "frac_bits=1e1", "frac_bits="))
def test_a_generic_is_a_plain_decimal_number(text: str) -> None:
    with pytest.raises(QuadshadeError, match="whole number"):
        parse_generics([text])


def test_the_help_lists_every_generic() -> None:
    for command in ("raster", "render"):
        text = quadshade(command, "--help").output
        for name, value in Formats().generics().items():
            assert f"{name}={value} " in text and GENERIC_HELP[name] in text


def test_without_a_command_the_help_is_shown() -> None:
    result = quadshade()
    assert result.exit_code == 0 and result.stdout == quadshade("--help").stdout and not result.stderr


def test_a_mistyped_command_is_suggested() -> None:
    result = quadshade("rendr", "sphere:24")
    assert is_one_line(result) and "'rendr', the nearest is 'render'" in result.stderr
    result = quadshade("xyzzy")
    assert is_one_line(result) and "nearest" not in result.stderr


@pytest.mark.parametrize(
    ("arguments", "hint"),
    (
        (("render", "none.obj", "-o", "a.png"), "give a mesh file"),
        (("pack", "none.stl", "-o", "a.qs"), "give a mesh file"),
        (("raster", "none.json", "-o", "a.npz"), "give a triangles file"),
        (("compare", "none.png", "none.png"), "give a PNG file"),
        (("dump", "none.qs"), "give a .qs file"),
        (("replay", "none.qs", "--port", "sim"), "give a .qs file"),
    ),
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_a_missing_file_has_one_wording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], hint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = quadshade(*arguments)
    assert is_one_line(result)
    assert (
        result.stderr == f"quadshade: error: cannot read {arguments[1]}: No such file or directory; {hint}\n"
    )
    (tmp_path / arguments[1]).mkdir()
    assert is_one_line(quadshade(*arguments))


def test_options_that_mean_nothing_are_not_offered() -> None:
    assert "--verify" not in quadshade("info", "--help").output
    packing = quadshade("pack", "--help").output
    assert all(word not in packing for word in ("phong is the reference", "--port", "--style", "--edges"))
    assert is_one_line(quadshade("pack", "sphere:24", "-o", "a.qs", "--shading", "phong"))


def test_ctrl_c_ends_the_program_while_it_imports(tmp_path: Path) -> None:
    """trimesh's imports would swallow the exception."""
    program = (
        "import builtins, os, signal\n"
        # What is started in the background of a script inherits that SIGINT is ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from quadshade.cli.main import main\n"
        "real = builtins.__import__\n"
        "def trapped(name, *rest):\n"
        "    if name == 'trimesh':\n"
        "        try:\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "        except BaseException:\n"
        "            pass\n"
        "    return real(name, *rest)\n"
        "builtins.__import__ = trapped\n"
        "main(['render', 'icosphere:0', '-o', 'a.png'])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "quadshade: interrupted\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "arguments",
    (
        ("--camera", "eye=0,0,1e300"),
        ("--camera", "from=1e300,0,0"),
        ("--camera", "ortho=1e-300"),
        ("--camera", "up=1e300,0,0"),
        ("--light", "dir=1e300,1e300,0"),
        ("--light", "point=1e200,0,0"),
        ("--light", "ambient=1e308"),
        ("--material", "colour=1e308,diffuse=1e308"),
        ("--reflectance", ""),
    ),
    ids=" ".join,
)
def test_numbers_out_of_all_proportion_are_refused(tmp_path: Path, arguments: tuple[str, str]) -> None:
    result = quadshade("render", "sphere:24", "-o", tmp_path / "a.png", "--size", "8x8", *arguments)
    assert is_one_line(result) and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "arguments",
    (
        ("--shading", "quadratic-specular", "--generic", "num_channels=1"),
        ("--edges", "inner", "--generic", "depth_bits=1"),
    ),
    ids=" ".join,
)
def test_an_error_comes_before_the_notices(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    arguments = ("--engine", "model", *arguments)
    assert is_one_line(quadshade("render", "cube:1", "-o", tmp_path / "a.png", "--size", "8x8", *arguments))


@pytest.mark.parametrize("body", ("raise SystemExit(0)", "return normal * 1j", "return np.log(normal - 2)"))
def test_a_reflectance_neither_ends_the_program_nor_warns(tmp_path: Path, body: str) -> None:
    module = tmp_path / "surface.py"
    module.write_text(f"import numpy as np\ndef f(point, normal, to_light, to_viewer):\n    {body}\n")
    arguments = ("-o", tmp_path / "a.png", "--size", "8x8", "--reflectance", f"{module}:f")
    assert is_one_line(quadshade("render", "sphere:24", *arguments))


INTERRUPTED = """
import {modules}
import click
# What is started in the background of a script inherits that SIGINT is ignored, below nohup SIGHUP.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.{hangup})
from quadshade.cli import main
@main.main.command()
def wait():
    {body}
main.COMMANDS = ("wait",)
main.OneLineErrors.get_command = click.Group.get_command
main.main(["wait"])
"""
BODIES = {
    "where it is": "os.kill(os.getpid(), signal.{number}); time.sleep(99)",
    "in a library that raises something else": (
        "\n    try: os.kill(os.getpid(), signal.{number}); time.sleep(99)"
        "\n    except BaseException: raise RuntimeError('no compiled object') from None"
    ),
    "where Python drops it": (
        "\n    class Kept:"
        "\n        def __del__(self): os.kill(os.getpid(), signal.{number}); time.sleep(99)"
        "\n    Kept(); time.sleep(99)"
    ),
}


@pytest.mark.parametrize(("number", "code"), (("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)))
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_a_signal_ends_the_program_at_once(number: str, code: int, body: str) -> None:
    body = body.format(number=number)
    program = INTERRUPTED.format(modules="os, signal, time", hangup="SIG_DFL", body=body)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (code, "", "quadshade: interrupted\n")


def test_an_interrupt_is_one_line_while_options_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(click.Command, "make_context", interrupted)
    result = quadshade("info")
    assert (result.exit_code, result.stderr) == (130, "quadshade: interrupted\n")


def test_an_interrupt_is_not_repeated_after_the_end() -> None:
    """It would kill the interpreter while it shuts down, with another exit code."""
    with pytest.raises(KeyboardInterrupt), interrupts.ending_in_order():
        interrupts._received.append(signal.SIGINT)
        interrupts._dropped(SimpleNamespace(exc_type=KeyboardInterrupt))
        raise KeyboardInterrupt
    time.sleep(2 * interrupts.AGAIN_SECONDS)


def test_a_signal_that_is_ignored_stays_ignored() -> None:
    """As `nohup` has it."""
    body = "os.kill(os.getpid(), signal.SIGHUP); print('on')"
    program = INTERRUPTED.format(modules="os, signal", hangup="SIG_IGN", body=body)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "on\n", "")


def test_a_user_who_can_write_nothing_but_the_picture(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """Neither beside the package nor at home, as a service that uses an installation of somebody else's."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/dev/null/loops")
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    monkeypatch.setattr(compiled_loops, "__file__", "/dev/null/module.py")
    for files, said in ((0, ""), (1, f"quadshade: notice: {compiled_loops.NOTICE}\n")):
        with compiled_loops.somewhere_for_compiled_loops():
            folder = Path(os.environ["NUMBA_CACHE_DIR"])
            for number in range(files):
                (folder / f"loop{number}").touch()
        assert not folder.exists() and os.environ["NUMBA_CACHE_DIR"] == "/dev/null/loops"
        assert capsys.readouterr().err == said


def test_the_usual_folders_for_compiled_loops_are_left_to_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    with compiled_loops.somewhere_for_compiled_loops():
        assert "NUMBA_CACHE_DIR" not in os.environ


@pytest.mark.skipif(shutil.which("ghdl") is None, reason="no ghdl")
@pytest.mark.parametrize(
    "arguments",
    (("--engine", "ghdl"), ("--engine", "ghdl", "--port", "sim"), ("--engine", "verilator", "--port", "sim")),
    ids=" ".join,
)
def test_a_checkout_that_cannot_be_written_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]
) -> None:
    root = Path(__file__).resolve().parents[1]
    for name in ("rtl", "sim", "synth"):
        (tmp_path / name).symlink_to(root / name)
    (tmp_path / "build").touch()
    monkeypatch.setenv("QUADSHADE_ROOT", str(tmp_path))
    result = quadshade("render", "sphere:24", "-o", tmp_path / "a.png", "--size", "8x8", *arguments)
    assert is_one_line(result) and result.stderr.endswith("; use --engine model\n")
    assert not (tmp_path / "a.png").exists()


def test_the_exit_code_is_right_where_nothing_can_be_said() -> None:
    program = [sys.executable, "-c", "from quadshade.cli.main import main; main()", "render"]
    with open("/dev/full", "w") as full:
        assert subprocess.run(program, stderr=full, check=False).returncode == 2


MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.mark.parametrize(
    "content", (b"\xef\xbb\xbf" + MESH.encode(), MESH.encode() + b"# Gr\xf6\xdfe\n"), ids=("mark", "latin-1")
)
def test_a_mesh_in_text_may_have_any_encoding(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "plain.obj").write_text(MESH)
    (tmp_path / "other.obj").write_bytes(content)
    for name in ("plain", "other"):
        result = quadshade(
            "render", tmp_path / f"{name}.obj", "-o", tmp_path / f"{name}.png", "--size", "9x9"
        )
        assert result.exit_code == 0, result.output
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "other.png").read_bytes()
    assert read_picture(tmp_path / "other.png").any()


def test_binary_junk_is_not_blamed_on_a_missing_package(tmp_path: Path) -> None:
    (tmp_path / "cut.stl").write_bytes(bytes(80) + b"\x07\xff\xff\x00" + bytes([200]) * 60)
    result = quadshade("render", tmp_path / "cut.stl", "-o", tmp_path / "a.png")
    assert is_one_line(result) and "charset" not in result.stderr and "module" not in result.stderr


def test_a_png_of_16_bits_is_refused(tmp_path: Path) -> None:
    """Pillow would halve its bits without a word."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 1, 16, 2, 0, 0, 0))
    rows = chunk(b"IDAT", zlib.compress(bytes(13)))
    path = tmp_path / "deep.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + header + rows + chunk(b"IEND", b""))
    with pytest.raises(QuadshadeError, match="more than 8 bits"):
        read_picture(path)
