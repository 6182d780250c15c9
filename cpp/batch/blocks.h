// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "batch/case_motion.h"
#include "linalg/lockstep.h"
#include <span>

namespace signorini::batch {

/// A case to be computed: its scene, or why it has none.
struct Case {
  std::optional<scene::Scene> scene;
  std::string reason;
};

/// Cases that are computed together, by their numbers. All share operators and D.
using Block = std::vector<std::size_t>;

/// Divides the cases with the numbers `wanted` into blocks of at most `most` that share D, in the order of
/// the cases. Each must have a scene.
std::vector<Block> blocks(const std::vector<Case>& cases, std::span<const std::size_t> wanted,
                          std::size_t most);

/// Computes blocks of cases on this rank alone.
class BlockRunner {
public:
  /// `quantities`: as in case_quantities(). `folders`: folders for all results of the cases' motions; empty:
  /// none. The references must outlive this object.
  BlockRunner(const std::vector<Case>& cases, const std::vector<std::string>& quantities,
              std::vector<std::filesystem::path> folders)
      : cases_(cases), quantities_(quantities), folders_(std::move(folders)) {}

  /// Computes the motions of a block; the solves of all are made together if CHOLMOD factorised D. Returns
  /// their outcomes in the order of the block.
  [[nodiscard]] std::vector<Outcome> run(const Block& block);

  /// Dimensions of the mesh read last; absent before.
  [[nodiscard]] std::optional<int> dim() const {
    return discretisation_ ? std::optional(discretisation_->mesh.dim()) : std::nullopt;
  }
  /// Quantities of the numbers of the case that was set up last; empty before.
  [[nodiscard]] const std::vector<accuracy::Quantity>& known() const { return known_; }

private:
  /// Makes discretisation_ that of a scene. Throws UserError.
  void discretise(const scene::Scene& scene);
  /// Makes leader_ a case with this operators_key() or none.
  void follow(const std::string& key);

  const std::vector<Case>& cases_;
  const std::vector<std::string>& quantities_;
  std::vector<std::filesystem::path> folders_;
  Timers timers_;
  std::shared_ptr<const problem::SpaceDiscretisation> discretisation_; ///< of the last block
  std::string mesh_;                                                   ///< what determines it
  std::string key_;                                                    ///< operators_key() of leader_
  std::unique_ptr<CaseMotion> leader_; ///< whose factorisation the cases of its blocks use
  std::vector<accuracy::Quantity> known_;
  Lockstep lockstep_;
};

} // namespace signorini::batch
