// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/reduced_problem.h"
#include "io/manifest.h"
#include "optimize/certificate.h"

namespace signorini::drivers {

/// Describes a kink by its certificate and the weak contact there: the candidates, by step, that are active
/// at some of its points and open at others. Makes a forward sweep for each point, which is not counted.
/// Throws Interrupted. Collective.
[[nodiscard]] io::Kink describe(control::ReducedProblem& reduced,
                                const optimize::Certificate<control::Variables>& certificate);

/// The same as numbers, in which a checkpoint stores it.
[[nodiscard]] std::vector<double> numbers(const io::Kink& kink);

/// From those numbers, in `dim` dimensions; none if they are not such.
[[nodiscard]] std::optional<io::Kink> kink_of(const std::vector<double>& numbers, int dim);

} // namespace signorini::drivers
