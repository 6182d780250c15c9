# SPDX-License-Identifier: GPL-3.0-or-later
"""What ./dev mutate makes of each line of a source: these changes and no others."""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[1]) / "tests" / "mutation"))
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


def main() -> int:
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sample.cpp"
        file.write_text("\n".join(LINES) + "\n")
        found: dict[int, list[str]] = {}
        for mutant in (m for choices in Source(file).mutants() for m in choices):
            found.setdefault(mutant.line, []).append(mutant.applied().splitlines()[mutant.line - 1])
        for number, (line, expected) in enumerate(LINES.items(), 1):
            if sorted(found.get(number, [])) != sorted(expected):
                wrong += 1
                print(f"{line}\n  became    {sorted(found.get(number, []))}\n  expected  {sorted(expected)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
