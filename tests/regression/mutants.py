# SPDX-License-Identifier: GPL-3.0-or-later
"""What ./dev mutate makes of each line of a source: these changes and no others."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[1]) / "tests" / "mutation"))
from python_sites import PythonSource  # noqa: E402
from sites import Source  # noqa: E402

# A line of the source, and what may become of it.
LINES = {
    '#define LESS(a, b) ((a) < (b)) // 1 + 1': [],
    'long& made = count("made + 2");': [],
    'constexpr double rounding = 0.5, limit = 4;': [],
    'struct StepOptions { double rounding = 0.5; int limit = 4; };': [],
    'template <class T, int n = 2>': [],
    'double f(const std::array<double, 3>& x, Vec y, int k) {': [],
    '  // y = x - 1;': [],
    '  ++made;': [],
    '  errno = 0;': [],
    '  out.reserve(2 * k);': [],
    '  check(MatRestoreRow(A, k));': [],
    '  if (k < 0) throw UserError(fmt::format("{} < {}", k - 1, 2));':
        ['  if (k >= 0) throw UserError(fmt::format("{} < {}", k - 1, 2));',
         '  if (k < 1) throw UserError(fmt::format("{} < {}", k - 1, 2));'],
    '  int found = -1;': [],
    '  const double a = -k * 0.25;': ['  const double a = k * 0.25;', '  const double a = -k / 0.25;', '  const double a = -k * 0.5;'],
    '  for (int i = k; i < dim(); ++i)': ['  for (int i = k; i >= dim(); ++i)', '  for (int i = k; i <= dim(); ++i)'],
    '    sum += x[i] * 1e-3;': ['    ;', '    sum -= x[i] * 1e-3;', '    sum += x[i + 1] * 1e-3;', '    sum += x[i] / 1e-3;'],
    '  solve(y, [&](int c) { return c; });': ['  ;', '  solve([&](int c) { return c; }, y);'],
    '  while (!done && dot(y, y) > tolerance)':
        ['  while (done && dot(y, y) > tolerance)', '  while (!done || dot(y, y) > tolerance)', '  while (!done && dot(y, y) <= tolerance)'],
    '    continue;': ['    ;'],
    '  return std::max(x.front(), x[0]);':
        ['  return std::min(x.front(), x[0]);', '  return std::max(x.back(), x[0]);', '  return std::max(x.front(), x[1]);'],
    '}': [],
}


# Where what is printed counts, so does what a text is made of.
PRINTED = {
    'void f(int k) {': [],
    '  line(fmt::format("{} < {}", k - 1, a));':
        ['  ;', '  line(fmt::format(k - 1, "{} < {}", a));', '  line(fmt::format("{} < {}", a, k - 1));', '  line(fmt::format("{} < {}", k + 1, a));',
         '  line(fmt::format("{} < {}", k - 2, a));'],
    '  throw UserError(fmt::format("{}", k - 1));': [],
}  # fmt: skip
PYTHON = {
    '"""2 + 1 < 3 of an ä."""': [],
    'LIMIT = 0.5': [],
    'def f(x: list[2] = (), n: int = 1) -> "a + b":': ['def f(x: list[2] = (), n: int = 2) -> "a + b":'],
    '    if n < len(x) and not x[n]:':
        ['    if n >= len(x) and not x[n]:', '    if n <= len(x) and not x[n]:', '    if n < len(x) or not x[n]:', '    if n < len(x) and x[n]:',
         '    if n < len(x) and not x[n + 1]:'],
    '        raise ValueError(f"{n - 1}")': [],
    '    ü = "é" + f"{n - 1:.3g}"; u = -x * 0.25':
        ['    ü = "é" + f"{n + 1:.3g}"; u = -x * 0.25', '    ü = "é" + f"{n - 2:.3g}"; u = -x * 0.25', '    ü = "é" + f"{n - 1:.3g}"; u = x * 0.25',
         '    ü = "é" + f"{n - 1:.3g}"; u = -x / 0.25', '    ü = "é" + f"{n - 1:.3g}"; u = -x * 0.5'],
    '    u = u.reshape(-1, 3)': ['    u = u.reshape(-1, 4)', '    u = u.reshape(3, -1)'],
    '    u += n': ['    pass', '    u -= n'],
    '    x[n:] = g(u, n)': ['    pass', '    x[n:] = g(n, u)'],
    '    draw(x, width=2, shift=2)': ['    pass', '    draw(x, width=2, shift=3)'],
    '    return (u > 1e-3) & ~(x.argmin() == n)':
        ['    return (u <= 1e-3) & ~(x.argmin() == n)', '    return (u > 1e-3) | ~(x.argmin() == n)', '    return (u > 1e-3) & (x.argmin() == n)',
         '    return (u > 1e-3) & ~(x.argmax() == n)', '    return (u > 1e-3) & ~(x.argmin() != n)'],
}  # fmt: skip


def wrong(file: Path, lines: dict[str, list[str]], source: type, **more: bool) -> int:
    """How many lines become something else than what is expected."""
    file.write_text("\n".join(lines) + "\n")
    found: dict[int, list[str]] = {}
    for mutant in (m for choices in source(file, **more).mutants() for m in choices):
        found.setdefault(mutant.line, []).append(mutant.applied().splitlines()[mutant.line - 1])
    count = 0
    for number, (line, expected) in enumerate(lines.items(), 1):
        if sorted(found.get(number, [])) != sorted(expected):
            count += 1
            print(f"{line}\n  became    {sorted(found.get(number, []))}\n  expected  {sorted(expected)}")
    return count


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        count = wrong(folder / "sample.cpp", LINES, Source) + wrong(folder / "printed.cpp", PRINTED, Source, printed=True)
        count += wrong(folder / "sample.py", PYTHON, PythonSource)
    return 1 if count else 0


if __name__ == "__main__":
    raise SystemExit(main())
