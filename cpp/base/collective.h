// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mpi.h>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace signorini {

/// Number of this rank. Not collective.
inline int rank(MPI_Comm comm) {
  int r = 0;
  MPI_Comm_rank(comm, &r);
  return r;
}

/// Number of ranks. Not collective.
inline int ranks(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

/// Largest size of one message, bytes: MPI counts in int.
constexpr std::size_t largest_message = std::numeric_limits<int>::max();

/// Overwrites `bytes`, whose number is the same on every rank, with the bytes of rank `root`, in messages of
/// at most `largest` bytes. Collective.
inline void broadcast_bytes(MPI_Comm comm, std::span<std::byte> bytes, int root, std::size_t largest) {
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(bytes.size(), largest)))
    MPI_Bcast(bytes.data(), static_cast<int>(std::min(bytes.size(), largest)), MPI_BYTE, root, comm);
}

/// Returns on every rank the text or numbers that rank `root` passes, sent in messages of at most `largest`
/// bytes. `Sequence`: a string or a vector of numbers. Collective.
template <class Sequence>
Sequence broadcast(MPI_Comm comm, Sequence values, int root = 0, std::size_t largest = largest_message) {
  auto size = static_cast<std::uint64_t>(values.size());
  MPI_Bcast(&size, 1, MPI_UINT64_T, root, comm);
  values.resize(static_cast<std::size_t>(size));
  broadcast_bytes(comm, std::as_writable_bytes(std::span(values)), root, largest);
  return values;
}

/// Concatenates the vectors of all ranks in the order of the ranks and returns the result on every rank. Uses
/// one MPI call if the result has at most `largest` bytes, else one broadcast per rank in messages of at most
/// that size. Collective.
template <class T>
std::vector<T> gather(MPI_Comm comm, const std::vector<T>& mine, std::size_t largest = largest_message) {
  const auto number = static_cast<std::size_t>(ranks(comm));
  const std::uint64_t own = mine.size() * sizeof(T);
  std::vector<std::uint64_t> sizes(number), starts(number, 0);
  MPI_Allgather(&own, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, comm);
  std::partial_sum(sizes.begin(), sizes.end() - 1, starts.begin() + 1);
  std::vector<T> all((starts.back() + sizes.back()) / sizeof(T));
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(all));
  if (bytes.size() <= largest) {
    const std::vector<int> counts(sizes.begin(), sizes.end()), offsets(starts.begin(), starts.end());
    MPI_Allgatherv(mine.data(), static_cast<int>(own), MPI_BYTE, all.data(), counts.data(), offsets.data(),
                   MPI_BYTE, comm);
    return all;
  }
  std::ranges::copy(mine, all.begin() + static_cast<std::ptrdiff_t>(starts[rank(comm)] / sizeof(T)));
  for (std::size_t r = 0; r < number; ++r)
    broadcast_bytes(comm, bytes.subspan(starts[r], sizes[r]), static_cast<int>(r), largest);
  return all;
}

/// Runs `work` on rank 0 only. If `work` throws a Failure or an OutputFailure there, every rank throws the
/// same exception, so that no rank waits for another one. Collective.
template <class Failure = UserError, class Work>
void on_root(MPI_Comm comm, Work&& work) {
  if (ranks(comm) == 1) { // avoids the allocations of a broadcast
    work();
    return;
  }
  constexpr char of_output = 'o', other = 'f';
  std::string problem; // preceded by a character for the type of the exception
  if (rank(comm) == 0) {
    try {
      work();
    } catch (const OutputFailure& error) {
      problem = of_output + std::string(error.what());
    } catch (const Failure& error) {
      problem = other + std::string(error.what());
    }
  }
  problem = broadcast(comm, problem);
  if (problem.starts_with(of_output))
    throw OutputFailure(problem.substr(1));
  if (!problem.empty())
    throw Failure(problem.substr(1));
}

/// Runs `work` on every rank. If it throws UserError on some ranks, every rank throws UserError with the text
/// of the lowest of these ranks. Collective.
template <class Work>
void on_all_ranks(MPI_Comm comm, Work&& work) {
  std::string problem;
  try {
    work();
  } catch (const UserError& error) {
    problem = error.what();
  }
  const int size = ranks(comm);
  int mine = problem.empty() ? size : rank(comm), first = mine;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first < size)
    throw UserError(broadcast(comm, problem, first));
}

/// Stopwatch that starts with its construction.
class Elapsed {
public:
  explicit Elapsed(MPI_Comm comm) : comm_(comm) {}
  /// Wall-clock time since construction in seconds, measured on rank 0 and the same on all ranks. Collective.
  [[nodiscard]] double seconds() const {
    double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    MPI_Bcast(&seconds, 1, MPI_DOUBLE, 0, comm_);
    return seconds;
  }

private:
  MPI_Comm comm_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace signorini
