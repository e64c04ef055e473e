# SPDX-License-Identifier: Apache-2.0
"""Packed pictures: files there and back, through a board's model, damaged in every way; the commands."""

from __future__ import annotations

import struct
import zlib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image

from quadshade.cli.main import main
from quadshade.contract.formats import Formats
from quadshade.contract.protocol import definition_hash
from quadshade.errors import QuadshadeError
from quadshade.golden.board import BoardModel
from quadshade.link.planes import read_picture
from quadshade.link.session import Session
from quadshade.link.transport import MemoryTransport
from quadshade.packing.frame_dump import packet_lines, summary_lines
from quadshade.packing.frame_file import (
    GENERICS,
    MAGIC,
    MAX_BLOCK,
    FrameFile,
    block,
    decode_frame_file,
    encode_frame_file,
    line_bytes,
    pack_frame,
    read_frame_file,
)
from quadshade.scene import load_scene, parse_camera, project
from quadshade.setup.packet import pack
from quadshade.shading import sample
from quadshade.shading.specular import sample_specular, specular_formats
from tests.support.setup_reference import screen_triangles

WIDTH, HEIGHT = 40, 30


def small_frame(shading: str) -> FrameFile:
    """A sphere on a small screen."""
    formats = Formats()
    mesh = load_scene("sphere:168")
    projected = project(mesh, parse_camera("", mesh), WIDTH, HEIGHT, formats)
    if shading == "quadratic":
        triangles = sample(projected, shading, formats=formats)
    else:
        formats = specular_formats({}, projected)
        triangles = sample_specular(projected, shading, formats=formats)
    frame, batch = pack_frame(triangles, formats, (1, 2, 3))
    assert np.array_equal(frame.set_up_words(), pack(batch.primitives, formats))
    return frame


def assert_same(frame: FrameFile, expected: FrameFile) -> None:
    """Every field is that of another file."""
    arrays = ("words", "state")
    for name in {field.name for field in fields(FrameFile)} - set(arrays):
        assert getattr(frame, name) == getattr(expected, name), name
    assert np.array_equal(frame.words, expected.words)
    for (address, words), (wanted_address, wanted) in zip(frame.state, expected.state, strict=True):
        assert (address, words.tolist()) == (wanted_address, wanted.tolist())


@pytest.fixture(scope="module")
def frame() -> FrameFile:
    return small_frame("quadratic")


@pytest.fixture(scope="module")
def content(frame: FrameFile) -> bytes:
    return encode_frame_file(frame)


@pytest.mark.parametrize("shading", ["quadratic", "quadratic-specular"])
def test_there_and_back(shading: str, tmp_path: Path) -> None:
    frame = small_frame(shading)
    (tmp_path / "frame.qs").write_bytes(encode_frame_file(frame))
    again = read_frame_file(tmp_path / "frame.qs")
    assert_same(again, frame)
    assert bool(frame.state) == (shading == "quadratic-specular")


def test_a_board_draws_what_the_file_says(frame: FrameFile) -> None:
    session = Session(MemoryTransport(BoardModel(WIDTH, HEIGHT, frame.formats).feed))
    session.connect()
    frame.send(session)
    assert session.frame_crc() == frame.crc
    assert session.frame_crc(1) == frame.depth_crc
    picture = read_picture(session)
    assert picture[0, 0].tolist() == [1, 2, 3]
    assert picture[HEIGHT // 2, WIDTH // 2].max() > 50
    sent = session.statistics["bytes_sent"]
    assert frame.line_bytes() == line_bytes(frame.words) < sent


def test_every_bit_is_guarded(content: bytes) -> None:
    rng = np.random.default_rng(1)
    for place in [*range(80), *rng.integers(0, len(content), 150).tolist(), len(content) - 1]:
        damaged = bytearray(content)
        damaged[place] ^= 1 << int(rng.integers(8))
        with pytest.raises(QuadshadeError):
            decode_frame_file(bytes(damaged))


def test_every_length_but_the_whole_is_refused(content: bytes) -> None:
    for length in [*range(120), *range(120, len(content), 97), len(content) - 1]:
        with pytest.raises(QuadshadeError, match=r"no \.qs file|cut short"):
            decode_frame_file(content[:length])
    with pytest.raises(QuadshadeError, match="behind the last block"):
        decode_frame_file(content + b"x")


PIECES = st.one_of(st.binary(max_size=30), st.sampled_from([b"HEAD", b"TRIS", b"STAT", b"DONE", b"\0" * 4]))


@given(st.lists(PIECES, max_size=12))
def test_any_bytes_raise_no_other_error(pieces: list[bytes]) -> None:
    with pytest.raises(QuadshadeError):
        decode_frame_file(MAGIC + b"".join(pieces))


HEADS = st.builds(
    lambda version, definition, rest, generics: (
        struct.pack("<HHI", version, len(GENERICS), definition)
        + rest
        + (bytes(Formats().generics().values()) if generics is None else generics)
    ),
    st.sampled_from([1, 1, 1, 2]),
    st.sampled_from([definition_hash(), definition_hash(), 7]),
    st.one_of(st.just(struct.pack("<HHIII", 8, 6, 0, 1, 1)), st.binary(min_size=16, max_size=16)),
    st.one_of(st.none(), st.binary(min_size=len(GENERICS), max_size=len(GENERICS))),
)
KINDS = st.sampled_from([b"TRIS", b"STAT", b"HEAD", b"DONE", b"NONE"])
CONTENTS = st.one_of(st.binary(max_size=24), st.sampled_from([bytes(4), bytes(8), b"\xff" * 64]))
ENDS = st.one_of(st.binary(min_size=12, max_size=12), st.sampled_from([bytes(12), b"\1" + bytes(11)]))


SOUND_HEAD = struct.pack("<HHIHHIII", 1, len(GENERICS), definition_hash(), 8, 6, 5, 1, 1) + bytes(
    Formats().generics().values()
)
STATES = [(b"STAT", struct.pack("<3I", 64, 1, 2)), (b"STAT", struct.pack("<2I", 7, 3))]


@given(HEADS, st.lists(st.tuples(KINDS, CONTENTS), max_size=4), ENDS)
@example(SOUND_HEAD, [], bytes(12))
@example(SOUND_HEAD, STATES, struct.pack("<3I", 0, 8, 9))
@example(SOUND_HEAD, [(b"NONE", bytes(8))], bytes(12))
@example(SOUND_HEAD, [(b"TRIS", bytes(6))], bytes(12))
@example(SOUND_HEAD, [(b"STAT", b"")], bytes(12))
def test_sound_blocks_raise_no_other_error(
    head: bytes, between: list[tuple[bytes, bytes]], end: bytes
) -> None:
    """Blocks with the right CRC are refused, or read as what they say: each field is where it stands."""
    text = [block(b"HEAD", head), *(block(*one) for one in between), block(b"DONE", end)]
    try:
        frame = decode_frame_file(MAGIC + b"".join(text))
    except QuadshadeError:
        assert head != SOUND_HEAD or between not in ([], STATES)
        return
    sizes = struct.unpack("<HHIII", head[8:24])
    assert (frame.width, frame.height, frame.clear_colour, frame.triangles, frame.packets) == sizes
    assert bytes(frame.formats.generics().values()) == head[24:]
    words = b"".join(data for kind, data in between if kind == b"TRIS")
    assert frame.words.astype("<u4").tobytes() == words
    assert struct.pack("<3I", len(frame.words), frame.crc, frame.depth_crc) == end
    state = [struct.pack("<I", address) + values.astype("<u4").tobytes() for address, values in frame.state]
    assert state == [data for kind, data in between if kind == b"STAT"]
    if all(len(values) for _, values in frame.state):
        assert_same(decode_frame_file(encode_frame_file(frame)), frame)


def test_state_of_several_blocks_goes_on_where_it_was(frame: FrameFile) -> None:
    state = ((5, np.arange(MAX_BLOCK // 2, dtype=np.uint32)),)
    again = decode_frame_file(encode_frame_file(replace(frame, state=state)))
    registers = {
        address + index: value
        for address, values in again.state
        for index, value in enumerate(values.tolist())
    }
    assert registers == {5 + index: index for index in range(MAX_BLOCK // 2)}


def test_words_are_as_many_as_the_last_block_says() -> None:
    for words in (0, 1, 3):
        blocks = [
            block(b"HEAD", SOUND_HEAD),
            block(b"TRIS", bytes(8)),
            block(b"DONE", struct.pack("<3I", words, 8, 9)),
        ]
        with pytest.raises(QuadshadeError, match=f"2 words, and not the {words} that"):
            decode_frame_file(MAGIC + b"".join(blocks))


@given(st.lists(st.integers(0, 0xFFFFFFFF), max_size=60), st.integers(1, 4096), st.integers(1, 4096))
def test_any_words_are_read_or_refused(words: list[int], width: int, height: int) -> None:
    """Packed words that mean nothing, in a file that is sound otherwise."""
    frame = FrameFile(Formats(), width, height, 0, np.array(words, np.uint32), 1, 1)
    try:
        assert np.array_equal(decode_frame_file(encode_frame_file(frame)).words, frame.words)
    except QuadshadeError as error:
        assert "within a packet" in str(error)


def test_other_formats_and_versions_are_said(frame: FrameFile, content: bytes) -> None:
    with pytest.raises(QuadshadeError, match=r"is of no known release \(00000001\), this is "):
        decode_frame_file(encode_frame_file(replace(frame, definition=1)))
    with pytest.raises(QuadshadeError, match="no .qs file"):
        decode_frame_file(b"\x89PNG\r\n\x1a\n" + content)


def run(*arguments: object) -> tuple[int, str]:
    """Exit code and output of the command."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments], standalone_mode=True)
    return result.exit_code, result.output


def test_pack_and_dump(tmp_path: Path) -> None:
    path = tmp_path / "frame.qs"
    code, said = run("pack", "sphere:168", "-o", path, "--size", "64x48", "--background", "1,0,0")
    assert code == 0
    assert "bytes a triangle on the line" in said
    frame = read_frame_file(path)
    assert (frame.width, frame.height, frame.clear_colour) == (64, 48, 255)
    code, said = run("dump", path)
    assert code == 0
    assert said.count("packet ") == frame.packets
    assert f"crc: picture {frame.crc:08x}, depth {frame.depth_crc:08x}" in said
    assert run("dump", path, "--packets", str(10**30)) == (0, said)
    code, short = run("dump", path, "--packets", "2")
    assert code == 0
    assert said.startswith(short)
    assert short.count("packet ") == 2
    assert "colour value below " in short and "depth d_row top " in short and ", y " in short


def numbers_in(line: str) -> dict[str, float]:
    """What stands behind the colon of a line of a dump."""
    parts = [part.rsplit(" ", 1) for part in line.split(": ", 1)[1].split(", ")]
    return {name: float(number) for name, number in parts}


@pytest.mark.parametrize("with_depth", [0, 1])
def test_a_dump_says_what_was_set_up(with_depth: int, rng: np.random.Generator) -> None:
    """Every number of every packet, read back from the text, against the primitives that were packed."""
    formats = Formats(with_depth=with_depth)
    triangles = screen_triangles(
        rng.integers(-30 * 256, 90 * 256, (40, 3, 2)), formats, 60, 50, rng.uniform(0, 255, (40, 3, 6))
    )
    triangles.orders = rng.integers(0, 3, (40, 3))
    if with_depth:
        triangles.depth = rng.uniform(0, 65535, (40, 3))
    frame, batch = pack_frame(triangles, formats)
    drawn, header = batch.primitives, batch.primitives.header
    line, unpacked = line_bytes(batch.words), pack(drawn, formats).nbytes
    assert list(summary_lines(frame, "name"))[1] == (
        f"packed: {batch.words.nbytes} bytes, {line} on the line, {line / frame.triangles:.1f} a triangle;"
        f" as set-up words {unpacked}"
    )
    lines = iter([line for line in packet_lines(frame) if not line.startswith("  widths: ")])
    for index in range(len(drawn)):
        start, end = batch.starts[index : index + 2].tolist()
        assert next(lines).startswith(f"packet {index}: bits {start} to {end - 1}, {end - start} bits, ")
        second = int(header["has_second"][index])
        rows = [int(header[name][index]) for name in ("rows_first", "rows_second")[: 1 + second]]
        flags = [name for name in ("mirror", "fractional") if header[name][index]]
        text = [f"y {header['y'][index]}", f"rows {' + '.join(map(str, rows))}", *flags]
        assert next(lines).strip().split(", ") == text
        for name in ("major", "minor", "second")[: 2 + second]:
            line = next(lines)
            assert line.startswith(f"  {name}: ")
            assert numbers_in(line) == {part: v[index] for part, v in drawn.edges[name].items()}
        for channel, frac_bits in enumerate(formats.channel_frac_bits):
            line, order = next(lines), int(drawn.orders[index, channel])
            name = f"channel {channel}" if channel < 3 else "depth"
            assert line.startswith(f"  {name}, {('constant', 'linear', 'quadratic')[order]}: ")
            names = ("value", "d_row", "d_col", "dd_row", "dd_mixed", "dd_col")[: (1, 3, 6)[order]]
            values = drawn.words[index, channel] / 2.0**frac_bits
            assert numbers_in(line) == {
                name: float(f"{value:g}") for name, value in zip(names, values, strict=False)
            }
    assert next(lines, None) is None
    assert header["mirror"].any() and header["has_second"].any() and (header["y"] > 0).any()


def test_exact_packing_draws_what_render_draws(tmp_path: Path) -> None:
    scene = ("torus:288", "--size", "64x48", "--material", "colour=0.9,0.5,0.1")
    assert run("pack", *scene, "-o", tmp_path / "a.qs", "--pack-error", "0")[0] == 0
    assert run("render", *scene, "-o", tmp_path / "a.png", "--engine", "model")[0] == 0
    with Image.open(tmp_path / "a.png") as image:
        assert (
            zlib.crc32(np.asarray(image.convert("RGB")).tobytes()) == read_frame_file(tmp_path / "a.qs").crc
        )


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("pack", "sphere:168", "--shading", "phong"), "'phong' is not one of"),
        (("pack", "sphere:168", "--generic", "stream_width=64"), "stream_width is 64"),
        (("pack", "sphere:168", "--generic", "value_bits=7"), "value_bits is 7"),
        (("pack", "sphere:168", "--pack-error", "-1"), "grey levels from 0"),
        (("pack", "sphere:168", "--pack-error", "nan"), "grey levels from 0"),
        (("pack", "no_such.obj"), "no_such.obj"),
    ],
)
def test_wrong_options_are_one_line(arguments: tuple[str, ...], what: str, tmp_path: Path) -> None:
    code, said = run(*arguments, "-o", tmp_path / "x.qs", "--size", "32x24")
    assert code == 2
    assert what in said
    assert said.count("\n") == 1
    assert not (tmp_path / "x.qs").exists()


def test_files_that_are_not_there(tmp_path: Path) -> None:
    (tmp_path / "text.qs").write_text("hello")
    for name, what in (("none.qs", "cannot read"), ("text.qs", "no .qs file")):
        code, said = run("dump", tmp_path / name)
        assert (code, said.count("\n")) == (2, 1)
        assert what in said
