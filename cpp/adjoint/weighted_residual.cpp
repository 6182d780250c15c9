#include "adjoint/weighted_residual.h"
#include "adjoint/sweep.h"
#include <map>

namespace signorini::adjoint {
using petsc::check, petsc::dot;

EnrichedBody::EnrichedBody(const fem::Space& linear, const contact::Constraints* constraints, const scene::Scene& scene)
    : space_(linear.mesh(), 2), operators_(fem::assemble_operators(space_, scene.materials, true)),
      clamped_(space_, scene.clamps), enrichment_(fem::enrich(linear, space_)) {
  if (!constraints)
    return;
  constraints_.emplace(space_, clamped_, scene.contacts);
  match(*constraints);
  zero_.assign(ends_.size(), 0.0);
}

void EnrichedBody::match(const contact::Constraints& constraints) {
  const int dim = space_.dim();
  std::map<std::pair<PetscInt, int>, int> candidate; // by node and obstacle
  for (int i = 0; i < constraints.count(); ++i)
    candidate[{constraints.first_dofs()[i] / dim, constraints.obstacles()[i]}] = i;
  constexpr int elsewhere = -2; // known to another rank
  ends_.assign(static_cast<std::size_t>(constraints_->count()), {elsewhere, elsewhere});
  const Mat embed = petsc::component(enrichment_.embed);
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(embed, &begin, &end));
  for (std::size_t j = 0; j < ends_.size(); ++j) {
    const PetscInt node = constraints_->first_dofs()[j] / dim;
    if (node < begin || node >= end)
      continue;
    PetscInt count = 0;
    const PetscInt* nodes = nullptr;
    check(MatGetRow(embed, node, &count, &nodes, nullptr));
    const auto at = [&](PetscInt n) {
      const auto found = candidate.find({n, constraints_->obstacles()[j]});
      return found == candidate.end() ? -1 : found->second;
    };
    ends_[j] = {at(nodes[0]), at(nodes[count - 1])};
    check(MatRestoreRow(embed, node, &count, &nodes, nullptr));
  }
  MPI_Allreduce(MPI_IN_PLACE, ends_.data(), 2 * constraints_->count(), MPI_INT, MPI_MAX, space_.comm());
}

void EnrichedBody::surplus(Vec p, const contact::ActiveSet& active, Vec out) const {
  check(MatMult(enrichment_.surplus, p, out));
  clamped_.clear(out);
  if (!constraints_ || active.empty())
    return;
  contact::ActiveSet between;
  const auto closed = [&](int i) { return std::ranges::binary_search(active, i); };
  for (std::size_t j = 0; j < ends_.size(); ++j)
    if (closed(ends_[j][0]) && closed(ends_[j][1]))
      between.push_back(static_cast<int>(j));
  constraints_->drop_dependent(between);
  constraints_->set_normal(between, zero_, out);
}

namespace {

/// A motion around t_k, for k from N down.
class Window {
public:
  struct Instant {
    petsc::Vector y, v;
  };

  Window(const fem::Space& space, const forward::Trajectory& trajectory) : trajectory_(trajectory) {
    for (Instant* x : {&later, &now, &before})
      *x = {space.vector(), space.vector()};
    fill(trajectory.steps(), before);
  }

  /// To t_k after t_{k+1}.
  void move(int k) {
    std::swap(later, now);
    std::swap(now, before);
    fill(k - 1, before);
  }

  Instant later, now, before;

private:
  void fill(int k, const Instant& x) const {
    const forward::States::View state = trajectory_.at(k);
    check(VecCopy(state.y, x.y));
    check(VecCopy(state.v, x.v));
  }

  const forward::Trajectory& trajectory_;
};

/// What is left of the equation of motion of step k in functions of degree 2: f − M a − B w − A ȳ.
class Residual {
public:
  Residual(const EnrichedBody& body, const Window& motion, const forward::Load& load, double tau)
      : body_(body), motion_(motion), load_at_(body.space(), load), tau_(tau), coarse_(petsc::zero_like(motion.now.y)),
        fine_(body.space().vector()), sum_(body.space().vector()), product_(body.space().vector()) {}

  Vec operator()(int k) {
    const fem::Operators& operators = body_.operators();
    forward::force_of(load_at_(k), operators, sum_);
    subtract(operators.M, 1 / tau_, motion_.now.v, -1 / tau_, motion_.before.v);
    if (operators.B)
      subtract(*operators.B, 1 / tau_, motion_.now.y, -1 / tau_, motion_.before.y);
    subtract(operators.A, 0.5, motion_.now.y, 0.5, motion_.before.y);
    return sum_;
  }

private:
  /// sum −= matrix (a x + b y)
  void subtract(Mat matrix, double a, Vec x, double b, Vec y) {
    check(VecAXPBYPCZ(coarse_, a, b, 0, x, y));
    check(MatMult(body_.enrichment().embed, coarse_, fine_));
    check(MatMult(matrix, fine_, product_));
    check(VecAXPY(sum_, -1, product_));
  }

  const EnrichedBody& body_;
  const Window& motion_;
  forward::LoadAtStep load_at_;
  double tau_;
  petsc::Vector coarse_, fine_, sum_, product_;
};

/// The time part, interface by interface between steps, from the last one on.
class TimePart {
public:
  TimePart(const forward::Stepper& stepper, const Window& motion, int steps, const forward::Load& load)
      : stepper_(stepper), motion_(motion), steps_(steps), load_at_(stepper.space(), load), tau_(stepper.scheme().tau),
        rate_(stepper.space().vector()), later_(stepper.space().vector()), force_(stepper.space().vector()),
        force_later_(stepper.space().vector()), moves_(stepper.space().vector()), product_(stepper.space().vector()) {}

  /// Takes p_k after p_{k+1}.
  void take(int k, Vec p) {
    std::swap(force_, force_later_);
    forward::force_of(load_at_(k), stepper_.operators(), force_);
    // π' = (p_{k+1} − p_k)/2, with p_{N+1} = 0
    check(VecAXPBYPCZ(rate_, -0.5, 0.5, 0, p, later_));
    const bool last = k == steps_;
    sum_ += (last ? 0.5 : 1) * tau_ * at_interface(last);
    if (k == 1)
      start(p);
    check(VecCopy(p, later_));
  }

  [[nodiscard]] double sum() const { return sum_; }

private:
  double weighed(Mat matrix) {
    check(MatMult(matrix, moves_, product_));
    stepper_.clamped().clear(product_);
    return dot(rate_, product_);
  }

  /// At t_k, per time.
  double at_interface(bool last) {
    const fem::Operators& body = stepper_.operators();
    double value = 0;
    if (last) {
      check(VecCopy(motion_.now.v, moves_));
      return -tau_ * tau_ / 6 * weighed(body.A);
    }
    check(VecAXPBYPCZ(moves_, 0.5 / tau_, -0.5 / tau_, 0, motion_.later.y, motion_.before.y));
    value -= tau_ * tau_ / 6 * weighed(body.A);
    if (body.B) {
      check(VecAXPBYPCZ(moves_, 1, 1, 0, motion_.later.y, motion_.before.y));
      check(VecAXPY(moves_, -2, motion_.now.y));
      value -= weighed(*body.B) / 12;
    }
    check(VecWAXPY(moves_, -1, force_, force_later_));
    return value + tau_ / 24 * dot(rate_, moves_);
  }

  /// The boundary terms at t = 0, π(0) = τ/2 p_1, and half an interval of the first interface's rate.
  void start(Vec p) {
    const Mat A = stepper_.operators().A;
    check(VecCopy(motion_.before.v, moves_));
    sum_ -= tau_ * tau_ / 6 * weighed(A) * tau_ / 2;
    check(MatMult(A, moves_, product_));
    sum_ -= tau_ * tau_ / 12 * tau_ / 2 * dot(p, product_);
    if (steps_ > 1) {
      check(VecWAXPY(moves_, -1, force_, force_later_));
      sum_ -= tau_ / 24 * tau_ / 2 * dot(p, moves_);
    }
  }

  const forward::Stepper& stepper_;
  const Window& motion_;
  int steps_;
  forward::LoadAtStep load_at_;
  double tau_, sum_ = 0;
  petsc::Vector rate_, later_, force_, force_later_, moves_, product_;
};

} // namespace

ErrorParts weighted_residual(const forward::Stepper& stepper, const EnrichedBody* enriched, const forward::Trajectory& trajectory,
                             const forward::Load& load, const forward::Load& enriched_load, const forward::Load& derivative) {
  const forward::Scheme& scheme = stepper.scheme();
  Window motion(stepper.space(), trajectory);
  TimePart time(stepper, motion, trajectory.steps(), load);
  std::optional<Residual> residual;
  petsc::Vector surplus;
  if (enriched) {
    residual.emplace(*enriched, motion, enriched_load, scheme.tau);
    surplus = enriched->space().vector();
  }
  ErrorParts parts;
  double space = 0;
  sweep(stepper, trajectory.contact(), derivative, [&](int k, Vec p) {
    motion.move(k);
    time.take(k, p);
    if (enriched) {
      enriched->surplus(p, trajectory.contact()[static_cast<std::size_t>(k)].active, surplus);
      space += scheme.impulse() * dot(surplus, (*residual)(k));
    }
  });
  parts.time = time.sum();
  if (enriched)
    parts.space = space;
  return parts;
}

} // namespace signorini::adjoint
