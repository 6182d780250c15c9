#pragma once
#include <cholmod.h>
#include <span>

namespace signorini {

/// Forward solve z ← L⁻¹ z with a supernodal factor L of CHOLMOD (real, 32-bit indices). z: (L.n); work: at
/// least L.maxesize values. Not collective. Faster than CHOLMOD's own solve, which calls the BLAS for every
/// supernode, since it prefetches the next supernodes from memory (`./dev bench scaling`).
void supernodal_forward(const cholmod_factor& L, std::span<double> z, std::span<double> work);

/// Backward solve z ← L⁻ᵀ z, likewise.
void supernodal_backward(const cholmod_factor& L, std::span<double> z, std::span<double> work);

} // namespace signorini
