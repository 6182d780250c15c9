// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/lockstep.h"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <ucontext.h>

namespace signorini {

namespace {

/// Bytes of a task's stack; the system gives memory to the pages that are used.
constexpr std::size_t stack_size = std::size_t{4} << 20;

} // namespace

struct Lockstep::Task {
  std::unique_ptr<std::byte[]> stack{new std::byte[stack_size]}; // not set to zero, which would use all pages
  ucontext_t here{}, caller{};
  const std::function<void()>* work = nullptr;
  SharedSolve* asked = nullptr; ///< the solve for which the task waits
  bool ended = false;
  std::exception_ptr failure;
};

Lockstep::Lockstep() = default;
Lockstep::~Lockstep() = default;

void Lockstep::enter(unsigned high, unsigned low) { // an address in two words, as makecontext() has integers
  Task& task = *reinterpret_cast<Task*>((static_cast<std::uintptr_t>(high) << 32) | low);
  try {
    (*task.work)();
  } catch (...) {
    task.failure = std::current_exception();
  }
  task.ended = true;
  swapcontext(&task.here, &task.caller); // for good
}

void Lockstep::resume(Task& task) {
  current_ = &task;
  swapcontext(&task.caller, &task.here);
  current_ = nullptr;
}

void Lockstep::wait(SharedSolve& solve) {
  Task& task = *current_;
  task.asked = &solve;
  swapcontext(&task.here, &task.caller);
}

void Lockstep::run(const std::vector<std::function<void()>>& works) {
  running_ = works.size();
  while (tasks_.size() < works.size())
    tasks_.push_back(std::make_unique<Task>());
  for (std::size_t i = 0; i < works.size(); ++i) {
    Task& task = *tasks_[i];
    task.work = &works[i];
    task.asked = nullptr;
    task.ended = false;
    task.failure = nullptr;
    getcontext(&task.here);
    task.here.uc_stack.ss_sp = task.stack.get();
    task.here.uc_stack.ss_size = stack_size;
    task.here.uc_link = nullptr;
    const auto address = reinterpret_cast<std::uintptr_t>(&task);
    makecontext(&task.here, reinterpret_cast<void (*)()>(&Lockstep::enter), 2,
                static_cast<unsigned>(address >> 32), static_cast<unsigned>(address));
    resume(task);
  }
  std::vector<SharedSolve*> together;
  const auto waiting = [&](const std::unique_ptr<Task>& task) { return task->asked != nullptr; };
  const auto all = std::span(tasks_).first(works.size());
  for (auto first = std::ranges::find_if(all, waiting); first != all.end();
       first = std::ranges::find_if(all, waiting)) {
    const void* const kind = (*first)->asked->kind();
    together.clear();
    std::vector<Task*> served;
    for (const std::unique_ptr<Task>& task : all)
      if (task->asked && task->asked->kind() == kind) {
        together.push_back(task->asked);
        served.push_back(task.get());
      }
    together.front()->make(together);
    for (Task* task : served) {
      task->asked = nullptr;
      resume(*task);
    }
  }
  for (const std::unique_ptr<Task>& task : all)
    if (task->failure)
      std::rethrow_exception(task->failure);
}

} // namespace signorini
