#pragma once
#include "base/error.h"
#include <mpi.h>
#include <numeric>
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

/// Returns the text or numbers of rank `root` on every rank. Collective.
template <class Sequence>
Sequence broadcast(MPI_Comm comm, Sequence values, int root = 0) {
  auto size = static_cast<long>(values.size());
  MPI_Bcast(&size, 1, MPI_LONG, root, comm);
  values.resize(static_cast<std::size_t>(size));
  MPI_Bcast(values.data(), static_cast<int>(size * sizeof(typename Sequence::value_type)), MPI_BYTE, root,
            comm);
  return values;
}

/// Returns the entries of all ranks, in the order of the ranks, on every rank. Collective.
template <class T>
std::vector<T> gather(MPI_Comm comm, const std::vector<T>& mine) {
  const int size = ranks(comm), bytes = static_cast<int>(mine.size() * sizeof(T));
  std::vector<int> counts(static_cast<std::size_t>(size)), starts(static_cast<std::size_t>(size), 0);
  MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::partial_sum(counts.begin(), counts.end() - 1, starts.begin() + 1);
  std::vector<T> all(static_cast<std::size_t>(starts.back() + counts.back()) / sizeof(T));
  MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), counts.data(), starts.data(), MPI_BYTE, comm);
  return all;
}

/// Runs `work` on rank 0; a Failure there is thrown on every rank, so that no rank is left waiting.
/// Collective.
template <class Failure = UserError, class Work>
void on_root(MPI_Comm comm, Work&& work) {
  if (ranks(comm) == 1) { // avoids the allocations of a broadcast
    work();
    return;
  }
  std::string problem;
  if (rank(comm) == 0) {
    try {
      work();
    } catch (const Failure& error) {
      problem = error.what();
    }
  }
  problem = broadcast(comm, problem);
  if (!problem.empty())
    throw Failure(problem);
}

/// Runs `work` on every rank; a UserError of any rank is thrown on all, with the text of the lowest rank that
/// threw. Collective.
template <class Work>
void together(MPI_Comm comm, Work&& work) {
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

} // namespace signorini
