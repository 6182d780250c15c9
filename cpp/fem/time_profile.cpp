// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/time_profile.h"
#include "base/collective.h"
#include "base/error.h"
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace signorini::fem {
namespace {

using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;

constexpr std::array<double, 3> origin{};
/// Tolerances relative to the integral over the run: for the difference of the two rules on a panel, and for
/// changes between the samples of a panel.
constexpr double quadrature_tolerance = 1e-10, unseen = 1e-9;
/// Least ratio of the samples' range to the enclosure's width: enclosures are wider than the range of the
/// values.
constexpr double explained = 0.25;
constexpr std::size_t first_samples = 200, more_samples = 20, most_panels = 1 << 18;
constexpr double shortest_panel = 0x1p-50; ///< shortest length of a panel relative to the run
constexpr double tiny = 1e-300;            ///< below any load or motion, but not denormal

/// Calls take(position in 0 … 1, weight) for each point of a rule; the weights add up to one.
template <class Rule, class Take>
void for_each_point(Take&& take) {
  const auto& abscissa = Rule::abscissa();
  const auto& weights = Rule::weights();
  for (std::size_t i = 0; i < abscissa.size(); ++i) {
    take((1 + abscissa[i]) / 2, weights[i] / 2);
    if (abscissa[i] != 0)
      take((1 - abscissa[i]) / 2, weights[i] / 2);
  }
}

/// Calls take(position in 0 … 1, weight) for points that integrate over a fraction `part` of a panel; a
/// smaller fraction needs fewer points. The error of n points is at most part^(2n) times the difference of
/// the two rules that a panel may have.
template <class Take>
void for_part_of_panel(double part, Take&& take) {
  using boost::math::quadrature::gauss;
  if (part > 1.0 / 2)
    for_each_point<Kronrod>(take);
  else if (part > 1.0 / 16)
    for_each_point<gauss<double, 7>>(take);
  else if (part > 1.0 / 256)
    for_each_point<gauss<double, 4>>(take);
  else
    for_each_point<gauss<double, 2>>(take);
}

scene::Interval hull(const scene::Interval& a, const scene::Interval& b) {
  return {std::min(a.lower(), b.lower()), std::max(a.upper(), b.upper())};
}

double width(const scene::Interval& range) { return range.upper() - range.lower(); }

std::vector<double> all_of(MPI_Comm comm, std::vector<double> mine, MPI_Op operation) {
  MPI_Allreduce(MPI_IN_PLACE, mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE, operation, comm);
  return mine;
}

} // namespace

TimeProfile::TimeProfile(MPI_Comm comm, scene::Field field, const std::vector<double>& points, double end)
    : comm_(comm), field_(std::move(field)), points_(points), end_(end), knots_(field_.knots()) {
  if (!field_.depends_on_time())
    return;
  std::erase_if(knots_, [&](double t) { return !(t > 0 && t < end); });
  std::ranges::sort(knots_);
  make_panels();
  const auto range = [](std::span<const double> values) {
    const auto [least, most] = std::ranges::minmax(values);
    return most - least;
  };
  const auto integral = [&](std::span<const double> values) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      sum += nodes_[i].weight * std::abs(values[i]);
    return sum * end_;
  };
  range_ = largest(0, end, true, range);
  integral_ = largest(0, end, false, integral);
}

std::size_t TimeProfile::places(std::size_t component) const {
  return field_.depends_on_place(component) ? points_.size() / 3 : 1;
}

const double* TimeProfile::place(std::size_t component, std::size_t i) const {
  return field_.depends_on_place(component) ? &points_[3 * i] : origin.data();
}

void TimeProfile::make_panels() {
  std::array<double, 6> corners; // the least coordinates, and the negatives of the greatest
  corners.fill(std::numeric_limits<double>::infinity());
  const std::size_t count = points_.size() / 3;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = std::min(corners[c], points_[3 * i + c]);
      corners[3 + c] = std::min(corners[3 + c], -points_[3 * i + c]);
    }
  MPI_Allreduce(MPI_IN_PLACE, corners.data(), 6, MPI_DOUBLE, MPI_MIN, comm_);
  for (std::size_t c = 0; c < 3; ++c)
    box_[c] = scene::Interval(corners[c], -corners[3 + c]);
  for (std::size_t i = 0; i < std::min(first_samples, count); ++i)
    samples_.push_back(i * count / std::min(first_samples, count));
  double begin = 0;
  for (const double knot : knots_)
    if (knot > begin)
      panels_.push_back({begin, knot}), begin = knot;
  panels_.push_back({begin, end_});
  while (std::ranges::any_of(panels_, &Panel::open))
    refine();
  for (Panel& panel : panels_)
    panel.suspects = {};
}

void TimeProfile::refine() {
  const std::size_t size = field_.size();
  // For each open panel, over all samples: the difference of two rules, the integral of the modulus and the
  // greatest values; the least values.
  std::vector<double> most, least;
  on_all_ranks(comm_, [&] {
    for (const Panel& panel : panels_)
      if (panel.open)
        sample(panel, most, least);
  });
  most = all_of(comm_, std::move(most), MPI_MAX);
  least = all_of(comm_, std::move(least), MPI_MIN);
  std::size_t k = 0; // number of the open panel
  for (Panel& panel : panels_)
    if (panel.open)
      panel.integral = most[(k++) * (2 + size) + 1];
  double whole = 0;
  for (const Panel& panel : panels_)
    whole += panel.integral;
  std::vector<double> cuts;
  k = 0;
  for (Panel& panel : panels_) {
    if (!panel.open)
      continue;
    const double* of = &most[k * (2 + size)];
    bool good = of[0] <= quadrature_tolerance * whole;
    panel.width = 0;
    for (std::size_t c = 0; c < size; ++c)
      if (needs_quadrature(c)) {
        const scene::Interval sampled = of[2 + c] >= least[k * size + c]
                                            ? scene::Interval(least[k * size + c], of[2 + c])
                                            : scene::Interval(0);
        good &= samples_cover_enclosure(sampled, panel, c, unseen * whole / (panel.end - panel.begin) + tiny);
        panel.width = std::max(panel.width, width(sampled));
      }
    cuts.push_back(!good);
    ++k;
  }
  halve(all_of(comm_, std::move(cuts), MPI_MAX), whole);
}

void TimeProfile::halve(const std::vector<double>& cuts, double whole) {
  std::vector<Panel> next;
  std::size_t k = 0;
  const std::size_t before = panels_.size();
  for (Panel& panel : panels_) {
    if (!panel.open || cuts[k++] == 0) {
      panel.open = false;
      next.push_back(std::move(panel));
      continue;
    }
    const double middle = (panel.begin + panel.end) / 2;
    if (panel.end - panel.begin < shortest_panel * end_ || next.size() + before > most_panels) {
      const double off = (panel.end - panel.begin) * panel.width / whole;
      unresolved_ += std::isfinite(off) ? off : 1;
      panel.open = false;
      next.push_back(std::move(panel));
      continue;
    }
    Panel half = panel;
    half.end = middle;
    next.push_back(std::move(half));
    panel.begin = middle;
    next.push_back(std::move(panel));
  }
  panels_ = std::move(next);
}

void TimeProfile::sample(const Panel& panel, std::vector<double>& most, std::vector<double>& least) const {
  const std::size_t size = field_.size();
  const double length = panel.end - panel.begin;
  double difference = 0, modulus = 0;
  std::vector<double> high(size, -std::numeric_limits<double>::infinity()), low(size, -high[0]);
  for (std::size_t c = 0; c < size; ++c) {
    if (!needs_quadrature(c))
      continue;
    const std::size_t count = field_.depends_on_place(c) ? samples_.size() : 1;
    for (std::size_t i = 0; i < count; ++i) {
      const double* x = place(c, field_.depends_on_place(c) ? samples_[i] : 0);
      // Every second pair of Kronrod's points, from the middle on, is one of Gauss's.
      const auto& gauss = boost::math::quadrature::gauss<double, 7>::weights();
      // Moments of three degrees, as symmetric rules agree on odd functions in any case.
      std::array<double, 3> off{};
      double positive = 0;
      std::size_t number = 0;
      for_each_point<Kronrod>([&](double at, double weight) {
        const double value = field_.value(c, x, panel.begin + length * at);
        const std::size_t pair = (++number) / 2; // 0, then twice 1, 2, …
        positive += weight * std::abs(value);
        double change = value * (pair % 2 == 0 ? weight - gauss[pair / 2] / 2 : weight);
        for (double& moment : off)
          moment += change, change *= 2 * at - 1;
        high[c] = std::max(high[c], value), low[c] = std::min(low[c], value);
      });
      for (const double moment : off)
        difference = std::max(difference, length * std::abs(moment));
      modulus = std::max(modulus, length * positive);
    }
  }
  most.insert(most.end(), {difference, modulus});
  most.insert(most.end(), high.begin(), high.end());
  least.insert(least.end(), low.begin(), low.end());
}

bool TimeProfile::samples_cover_enclosure(scene::Interval sampled, Panel& panel, std::size_t component,
                                          double enough) {
  const auto is = [&](const scene::Interval& range) {
    const double all = width(hull(range, sampled));
    panel.width = std::max(panel.width, all);
    return all <= width(sampled) / explained || all <= enough;
  };
  scene::Box box = box_;
  // Exclude the ends, at which a comparison with a knot is undecided.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  box[3] = scene::Interval(std::nextafter(panel.begin, infinity), std::nextafter(panel.end, -infinity));
  if (is(field_.enclose(component, box)))
    return true;
  if (!field_.depends_on_place(component))
    return false;
  // If the box is too wide for the enclosure, try the points one by one.
  std::vector<int> left;
  const auto look = [&](int i) {
    const double* x = &points_[3 * static_cast<std::size_t>(i)];
    for (std::size_t c = 0; c < 3; ++c)
      box[c] = scene::Interval(x[c]);
    if (!is(field_.enclose(component, box)))
      left.push_back(i);
  };
  if (panel.all_suspect)
    for (int i = 0; 3 * static_cast<std::size_t>(i) < points_.size(); ++i)
      look(i);
  else
    std::ranges::for_each(panel.suspects, look);
  for (std::size_t i = 0; i < std::min(more_samples, left.size()); ++i) {
    const auto sample = static_cast<std::size_t>(left[i * left.size() / std::min(more_samples, left.size())]);
    if (std::ranges::find(samples_, sample) == samples_.end())
      samples_.push_back(sample);
  }
  const bool none = left.empty();
  if (field_.size() == 1) // other components may have others
    panel.suspects = std::move(left), panel.all_suspect = false;
  return none;
}

void TimeProfile::set_nodes(std::size_t component, double from, double to) const {
  nodes_.clear();
  const double whole = to - from;
  if (const scene::TimeSeries* series = field_.series(component)) { // linear between its times: trapezoids
    const std::vector<double>& times = series->times();
    double before = from;
    nodes_.push_back({from, 0});
    const auto add = [&](double t) {
      const double half = (t - before) / (2 * whole);
      nodes_.back().weight += half;
      nodes_.push_back({t, half});
      before = t;
    };
    for (auto t = std::ranges::upper_bound(times, from); t != times.end() && *t < to; ++t)
      add(*t);
    add(to);
    return;
  }
  for (auto panel = std::ranges::upper_bound(panels_, from, {}, &Panel::end);
       panel != panels_.end() && panel->begin < to; ++panel) {
    const double begin = std::max(from, panel->begin), length = std::min(to, panel->end) - begin;
    if (length > 0)
      for_part_of_panel(length / (panel->end - panel->begin), [&](double at, double weight) {
        nodes_.push_back({begin + length * at, weight * length / whole});
      });
  }
}

void TimeProfile::mean(double from, double to, const std::vector<int>& components,
                       std::span<double> out) const {
  const std::size_t n = components.size();
  on_all_ranks(comm_, [&] {
    for (std::size_t j = 0; j < n; ++j) {
      const auto c = static_cast<std::size_t>(components[j]);
      if (field_.depends_on_time(c))
        set_nodes(c, from, to);
      else
        nodes_.assign(1, {0, 1});
      const std::size_t different = places(c);
      double value = 0;
      for (std::size_t i = 0; i * n < out.size(); ++i) {
        if (i < different) {
          value = 0;
          for (const Node& node : nodes_)
            value += node.weight * field_.value(c, place(c, i), node.t);
        }
        out[i * n + j] = value;
      }
    }
  });
}

void TimeProfile::mean(double from, double to, std::span<double> out) const {
  std::vector<int> all(field_.size());
  std::iota(all.begin(), all.end(), 0);
  mean(from, to, all, out);
}

template <class Measure>
double TimeProfile::largest(double from, double to, bool ends, Measure&& measure) const {
  double most = 0;
  on_all_ranks(comm_, [&] {
    for (std::size_t c = 0; c < field_.size(); ++c) {
      if (!field_.depends_on_time(c))
        continue;
      set_nodes(c, from, to);
      for (std::size_t i = 0; i < places(c); ++i) {
        values_.clear();
        if (ends)
          for (const double t : {from, to, (from + to) / 2})
            values_.push_back(field_.value(c, place(c, i), t));
        for (const Node& node : nodes_)
          values_.push_back(field_.value(c, place(c, i), node.t));
        most = std::max(most, measure(std::span<const double>(values_)));
      }
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm_);
  return most;
}

double TimeProfile::variation(double from, double to) const {
  if (!(integral_ > 0))
    return 0;
  const double most = largest(from, to, false, [&](std::span<const double> values) {
    double mean = 0, sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      mean += nodes_[i].weight * values[i];
    for (std::size_t i = 0; i < values.size(); ++i)
      sum += nodes_[i].weight * std::abs(values[i] - mean);
    return sum;
  });
  return most * (to - from) / integral_;
}

double TimeProfile::deviation(double from, double to) const {
  constexpr std::size_t ends = 3;
  return largest(from, to, true, [&](std::span<const double> values) {
    double most = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const double s = (nodes_[i].t - from) / (to - from), parabola = (1 - s) * (1 - 2 * s) * values[0] +
                                                                      s * (2 * s - 1) * values[1] +
                                                                      4 * s * (1 - s) * values[2];
      most = std::max(most, std::abs(values[i + ends] - parabola));
    }
    return most;
  });
}

std::vector<double> TimeProfile::times(double from, double to) const {
  std::vector<double> all;
  for (std::size_t c = 0; c < field_.size(); ++c)
    if (field_.depends_on_time(c)) {
      set_nodes(c, from, to);
      for (const Node& node : nodes_)
        all.push_back(node.t);
    }
  std::ranges::sort(all);
  return all;
}

void TimeProfile::require_resolved() const {
  if (unresolved() > noticeable)
    throw UserError(fmt::format("{}: the expression changes too fast to be integrated (its mean over a step "
                                "may have a relative error of {:.2g}). Use a slower expression or a time "
                                "series",
                                field_.key(), unresolved()));
}

} // namespace signorini::fem
