"""Numbers that are none, texts for them, and damage to the bytes of a file."""

from __future__ import annotations

from hypothesis import strategies as st

__all__ = ["BAD_NUMBERS", "damaged", "rarely"]

# What stands where a number should: no number, none of its range, or one in a way of writing that Python knows as well.
BAD_NUMBERS = [
    *("nan", "inf", "-inf", "1e309", "-1e309", "1e-320", "0", "-0.0", "-1", "-1e9", "9" * 400, "1e400", "0x10", "1_0"),
    *("", " ", "abc", "None", "true", "1,5", "1:2", "½", "٣", "1e", "--", "-", "é", "\n", "a\nb", "\x1b[31m", "\t1"),
    *("%s", "{}", "$HOME", "*", "~", "../x", "'", '"', "\\", "\udcff", "𝟙", "1" * 5000),
]


def rarely(draw: st.DrawFn, times: int) -> bool:
    """Once in so many times."""
    # Hypothesis prefers the smallest and the largest integer.
    return draw(st.integers(0, times - 1)) == times // 2


@st.composite
def damaged(draw: st.DrawFn, whole: bytes, times: int = 3) -> bytes:
    """The bytes of a file with one to `times` faults."""
    content = bytearray(whole)
    for _ in range(draw(st.integers(1, times))):
        begin = draw(st.integers(0, len(content)))
        end = min(len(content), begin + draw(st.integers(0, 40)))
        match draw(st.integers(0, 7)):
            case 0:
                del content[begin:]
            case 1:
                del content[begin:end]
            case 2:
                content[begin:begin] = draw(st.binary(min_size=1, max_size=20))
            case 3:
                content[begin:end] = draw(st.binary(min_size=end - begin, max_size=end - begin))
            case 4 if begin < len(content):
                content[begin] ^= 1 << draw(st.integers(0, 7))
            case 5:
                content[begin:begin] = content[begin:end] * draw(st.integers(1, 50))
            case 6:
                content[begin:end] = draw(st.sampled_from(BAD_NUMBERS)).encode(errors="replace")
            case 7:
                content[begin:end] = draw(
                    st.sampled_from([b"\0", b"\xff" * 8, b"\n", b",", b"[" * 50, b"\r\r\n", b"="])
                )
    return bytes(content)
