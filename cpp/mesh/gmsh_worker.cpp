// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/subprocess.h"
#include "mesh/gmsh_model.h"
#include "mesh/gmsh_request.h"
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <iterator>
#include <sys/resource.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

// The program signorini-gmsh, which answers one request: see in_subprocess().

namespace signorini::mesh {
namespace {

std::string answer(const std::string& bytes) {
  try {
    const GmshRequest request = request_of(bytes);
    if (request.written) {
      write_msh_here(*request.written, request.mesh.file, request.mesh.unit);
      return {done};
    }
    const Meshing meshing{.sizes = request.sizes ? &*request.sizes : nullptr, .keep = request.keep};
    return done + packed(read_gmsh_here(request.mesh, meshing, request.msh));
  } catch (const std::exception& error) {
    return failed + std::string(error.what());
  }
}

template <class Resource>
void limit(Resource resource, rlim_t most) {
  const rlimit both{.rlim_cur = most, .rlim_max = most};
  setrlimit(resource, &both);
}

} // namespace
} // namespace signorini::mesh

int main(int argc, char** argv) {
  using namespace signorini;
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) // the parent decides when to stop
    std::signal(signal, SIG_IGN);
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  mesh::limit(RLIMIT_CORE, 0);
  if (const int seconds = argc > 1 ? std::atoi(argv[1]) : 0; seconds > 0)
    mesh::limit(RLIMIT_CPU, static_cast<rlim_t>(seconds));
  const std::string request{std::istreambuf_iterator<char>(std::cin), {}}, answer = mesh::answer(request);
  std::FILE* out = fdopen(answer_file, "wb");
  const bool written = out && std::fwrite(answer.data(), 1, answer.size(), out) == answer.size();
  return written && std::fclose(out) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
