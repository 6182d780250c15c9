#pragma once
#include <cholmod.h>
#include <span>

namespace signorini {

/// z ← L⁻¹ z with a supernodal factor L of CHOLMOD (real, 32-bit indices). z: L.n values; work: at least
/// L.maxesize values. Rank-local. CHOLMOD's own solve calls the BLAS for every supernode and waits for
/// memory in between; this one asks for the next supernodes ahead (`./dev bench scaling`).
void supernodal_forward(const cholmod_factor& L, std::span<double> z, std::span<double> work);

/// z ← L⁻ᵀ z, the same way.
void supernodal_backward(const cholmod_factor& L, std::span<double> z, std::span<double> work);

} // namespace signorini
