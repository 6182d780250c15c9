// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/scene_file.h"
#include "problem/problem.h"
#include "session.h"

namespace signorini::python {

/// Scene and, once it is needed, its mesh.
class Scene final : public Open {
public:
  /// Reads the scene file. Collective. Throws UserError.
  Scene(const std::filesystem::path& file, const std::vector<std::string>& overrides);
  ~Scene() override { drop(release()); }
  std::shared_ptr<const void> release() override { return std::move(discretisation_); }

  [[nodiscard]] const app::SceneFile& file() const { return file_; }
  [[nodiscard]] const scene::Scene& scene() const { return file_.scene; }
  /// Mesh and spaces, made by the first call, which is collective. Throws UserError, Interrupted.
  std::shared_ptr<const problem::SpaceDiscretisation> discretisation();
  /// Scene as TOML with every default. Collective the first time. Throws UserError, Interrupted.
  std::string text();

private:
  app::SceneFile file_;
  std::shared_ptr<const problem::SpaceDiscretisation> discretisation_;
};

} // namespace signorini::python
