# SPDX-License-Identifier: GPL-3.0-or-later
"""What ./dev mutate makes of each line of a source: these changes and no others."""

from pathlib import Path

import pytest
from python_sites import PythonSource
from sites import Source

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
}  # fmt: skip
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


@pytest.mark.parametrize("file, lines, source, more", (("sample.cpp", LINES, Source, {}), ("printed.cpp", PRINTED, Source, {"printed": True}),
                                                       ("sample.py", PYTHON, PythonSource, {})), ids=("C++", "printed", "Python"))  # fmt: skip
def test_changes_of_each_line(file: str, lines: dict[str, list[str]], source: type, more: dict[str, bool], tmp_path: Path) -> None:
    (tmp_path / file).write_text("\n".join(lines) + "\n")
    found: dict[str, list[str]] = {line: [] for line in lines}
    for mutant in (m for choices in source(tmp_path / file, **more).mutants() for m in choices):
        found[list(lines)[mutant.line - 1]].append(mutant.applied().splitlines()[mutant.line - 1])
    assert {line: sorted(changes) for line, changes in found.items()} == {line: sorted(changes) for line, changes in lines.items()}
