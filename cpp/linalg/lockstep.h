// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace signorini {

/// A half of a solve that a task of a Lockstep asks for.
class SharedSolve {
public:
  virtual ~SharedSolve() = default;
  /// Makes this half and others of the same kind(), all at once.
  virtual void make(std::span<SharedSolve* const> all) = 0;
  /// Solver and half, as an address: halves of one kind are made together.
  [[nodiscard]] virtual const void* kind() const = 0;
};

/// Runs tasks in turns on one thread, each on a stack of its own: a task runs until it asks for a solve. When
/// all tasks have asked or have ended, the solves of one kind are made together, and the tasks continue. Code
/// for one motion thereby solves for many, while each keeps its own contact state. Tasks must not share data
/// that they change, and must not ask for solves while they handle an exception.
class Lockstep {
public:
  Lockstep();
  ~Lockstep();

  /// Runs the tasks to their ends. Throws the exception of the first task, by number, that threw one.
  void run(const std::vector<std::function<void()>>& tasks);

  /// Number of tasks of the run.
  [[nodiscard]] std::size_t tasks() const { return running_; }
  /// Whether the caller is a task.
  [[nodiscard]] bool inside() const { return current_ != nullptr; }
  /// Called by a task: waits until the solve has been made.
  void wait(SharedSolve& solve);

private:
  struct Task;
  static void enter(unsigned high, unsigned low);
  /// Lets a task run until it asks for a solve or ends.
  void resume(Task& task);

  std::vector<std::unique_ptr<Task>> tasks_; ///< with their stacks, which later runs take again
  std::size_t running_ = 0;
  Task* current_ = nullptr;
};

} // namespace signorini
