// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene.h"
#include "app/run.h"
#include "base/collective.h"
#include "bindings.h"
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace nb = nanobind;

namespace signorini::python {

Scene::Scene(const std::filesystem::path& file, const std::vector<std::string>& overrides)
    : file_(alone([&] { return app::read_scene(MPI_COMM_WORLD, file, overrides); })) {}

std::shared_ptr<const problem::SpaceDiscretisation> Scene::discretisation() {
  if (scene().mesh.automatic())
    throw UserError("mesh.size: found \"auto\", which simulate and optimize of the program choose; give a "
                    "size in m, such as {\"mesh.size\": 0.1}");
  if (!discretisation_) {
    Timers timers;
    discretisation_ = std::make_shared<const problem::SpaceDiscretisation>(MPI_COMM_WORLD, scene(), timers);
  }
  return discretisation_;
}

std::string Scene::text() { return scene::echo(scene(), discretisation()->space.dim()); }

namespace {

/// Runs a verb of the program on the scene as it was read; returns the exit status.
int run(const Scene& scene, const std::string& verb, const std::filesystem::path& out, bool resume,
        bool replace, bool quiet) {
  app::Request request;
  request.verb = verb;
  request.out = out;
  request.resume = resume;
  request.replace = replace;
  const bool speaks = !quiet && rank(MPI_COMM_WORLD) == 0;
  return compute([&] { return signorini::app::run(request, scene.file(), Console(speaks, false)); });
}

} // namespace

void bind_scene(nb::module_& module) {
  nb::class_<Scene>(module, "Scene")
      .def(nb::init<const std::filesystem::path&, const std::vector<std::string>&>())
      .def_prop_ro("file", [](const Scene& self) { return self.scene().file; })
      .def_prop_ro("name", [](const Scene& self) { return self.scene().name; })
      .def("text", [](Scene& self) { return compute([&] { return self.text(); }); })
      .def("run", run);
}

} // namespace signorini::python
