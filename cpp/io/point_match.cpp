#include "io/point_match.h"
#include "base/collective.h"
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <map>

namespace signorini::io {

namespace {

std::string place(const double* x, int dim) {
  return dim == 2 ? fmt::format("({:.6g}, {:.6g})", x[0], x[1])
                  : fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]);
}

} // namespace

std::vector<std::size_t> match_points(const fem::Space& space, const std::vector<double>& there,
                                      const std::vector<double>& here,
                                      const std::function<void(const std::string& problem)>& fail) {
  const auto dim = static_cast<std::size_t>(space.dim());
  // Points of one mesh agree to the last digits; a cell is so much larger than that that few of them lie near
  // its sides, and so small that it holds one.
  const double near = 1e-10 * space.mesh().diameter(), cell = 100 * near;
  using Cell = std::array<std::int64_t, 3>;
  const auto cell_of = [&](const double* x, double shift) {
    Cell at{};
    for (std::size_t c = 0; c < dim; ++c)
      at[c] = static_cast<std::int64_t>(std::floor((x[c] + shift) / cell + 0.5));
    return at;
  };
  std::vector<std::size_t> numbers;
  together(space.comm(), [&] {
    std::map<Cell, std::size_t> known;
    for (std::size_t i = 0; i < there.size() / dim; ++i)
      if (!known.emplace(cell_of(&there[i * dim], 0), i).second)
        fail(fmt::format("found two points at {} m, allowed are meshes whose nodes are apart",
                         place(&there[i * dim], space.dim())));
    for (std::size_t i = 0; i < here.size() / 3; ++i) {
      const double* x = &here[3 * i];
      const Cell low = cell_of(x, -near), high = cell_of(x, near);
      const auto found = [&] {
        for (Cell at = low; at[0] <= high[0]; ++at[0])
          for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
            for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
              if (const auto entry = known.find(at); entry != known.end())
                return entry;
        return known.end();
      }();
      if (found == known.end())
        fail(
            fmt::format("found no point at {} m, where this scene has one; allowed is a run on the same mesh",
                        place(x, space.dim())));
      numbers.push_back(found->second);
    }
  });
  return numbers;
}

} // namespace signorini::io
